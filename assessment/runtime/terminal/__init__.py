"""What people see of a run: standard output and error, progress, status."""
