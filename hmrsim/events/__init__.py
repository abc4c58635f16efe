"""What happens in the world: one frozen class an event, one file a subject, and how each is told in English."""
