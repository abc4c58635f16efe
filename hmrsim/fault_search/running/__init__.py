"""The running of schedules: worlds with their controllers, and what disturbs these."""
