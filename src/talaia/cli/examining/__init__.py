"""What the command line says of itself and of its machine: completion, and the doctor."""
