"""Several robots that share their work: a queue of tasks, their allocation, and the tree that carries them out."""
