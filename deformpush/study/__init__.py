"""Finished runs looked at together: tables, figures, pages, films."""
