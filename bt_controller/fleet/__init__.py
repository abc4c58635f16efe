"""Several robots that share their work: tasks, who gets which, and a tree that has it done."""
