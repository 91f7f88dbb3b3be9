"""Standards, projects and reports on top of `mechanics`."""
