"""Seeing: pictures, films, diagrams and report pages, made without a display."""
