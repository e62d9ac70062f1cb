"""What only one process may have at a time; a claim dies with the process that has it."""
