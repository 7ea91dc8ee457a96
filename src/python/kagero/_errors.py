"""The exceptions of kagero. The extension module raises them too."""


class InputError(ValueError):
    """Raised if an input is invalid: a scene, an override, an option or an array.

    The message states what was read, where, what was expected, and what to do.

    Attributes:
        file: path of the scene file, or the override that contains the input; None if it is unknown.
        line: line in the file, counted from 1; None if it is unknown.
        column: column in the line, counted from 1; None if it is unknown.
        key: for a scene from a dict, the path of the key, such as "camera.fov"; otherwise None.
    """

    def __init__(self, message, file=None, line=None, column=None, key=None):
        super().__init__(message)
        self.file = file
        self.line = line
        self.column = column
        self.key = key

    def __reduce__(self):
        return type(self), (self.args[0], self.file, self.line, self.column, self.key)


class RunError(RuntimeError):
    """Raised if a run fails, for example because there is not enough memory."""


class RunWarning(UserWarning):
    """Category of the warnings that the command line prints, and of interrupted runs."""
