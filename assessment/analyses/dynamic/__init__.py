"""Time histories and incremental dynamic analyses of every state."""
