"""What analyses leave in results.json: tables, frames, outlines, joint states, reactions."""
