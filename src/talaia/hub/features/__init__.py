"""The features of the hub: each builds itself in one file and says what it brings."""
