"""The search for the faults under which a controller fails, in simulation."""
