"""The page in the browser: a local server over the same project folder as the command line."""
