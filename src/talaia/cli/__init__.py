"""The command line: starts things; the only room that knows them all."""
