"""The one kind of error that is the user's to put right."""


class UserError(ValueError):
    """Says in one line what is wrong, where (key and value) and what is allowed; shown without a traceback, exit code 2."""
