"""The space of schedules: what can happen to the robots of a world, and at which moments."""
