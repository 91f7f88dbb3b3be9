"""What the report looks like: Jinja2 templates and style sheets, found through `importlib.resources`."""
