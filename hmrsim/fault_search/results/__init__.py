"""What a search gives to its user: a file that repeats each failure, its story, a page, JUnit XML."""
