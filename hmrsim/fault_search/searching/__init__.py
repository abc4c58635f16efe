"""The search: it proposes schedules, guided by earlier runs, and reduces those that fail."""
