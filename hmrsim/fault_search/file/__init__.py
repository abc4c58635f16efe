"""What is checked: the file of a check, and what a command line says in its place."""
