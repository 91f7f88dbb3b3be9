"""The project file and drawing: read, checked as a whole, and made into a model."""
