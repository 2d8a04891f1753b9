"""The one kind of error that is the user's to put right."""


class UserError(ValueError):
    """Says in one line which key or file, what is wrong with it and what is allowed.

    Shown without a traceback; the exit code is 2.
    """
