"""Results of a search: a reproducer and a story for each failure, a page, JUnit XML."""
