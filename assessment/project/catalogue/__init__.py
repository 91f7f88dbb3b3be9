"""The built-in templates: a new project from a few dimensions."""
