"""The parts that speak one robot protocol each."""
