"""Tests: folders mirror the packages; `support` holds what they share."""

from pathlib import Path

ROOT = Path(__file__).parents[1]
