"""Checks across the tables of a project file: names, files, and stages that need each other."""

from assessment.project.consistency.content import content_problems
from assessment.project.consistency.files import matches

__all__ = ["content_problems", "matches"]
