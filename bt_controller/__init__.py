"""Behaviour trees that drive robots from outside: a client of the simulator, in a process of its own."""
