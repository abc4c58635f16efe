"""The search: what is run next, guided by what the runs before have exercised."""
