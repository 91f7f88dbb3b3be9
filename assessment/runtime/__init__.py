"""What runs need of the machine: processes, stored results, files, interruption, progress."""
