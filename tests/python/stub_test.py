"""The stubs describe the package: names, parameters, defaults and docstrings are equal."""
import ast
import inspect
import pathlib
import unittest

import support  # noqa: F401  (adds the build folder to the path)
import kagero

STUB = pathlib.Path(kagero.__file__).with_name("__init__.pyi")


def parameters_of_stub(function):
    """Returns (name, kind, default) of each parameter of a function of the stub."""
    arguments = function.args
    positional = [argument.arg for argument in arguments.args]
    defaults = [None] * (len(positional) - len(arguments.defaults)) + [ast.unparse(d) for d in arguments.defaults]
    parameters = [(name, "positional", default) for name, default in zip(positional, defaults)]
    parameters += [(argument.arg, "keyword", default and ast.unparse(default))
                   for argument, default in zip(arguments.kwonlyargs, arguments.kw_defaults)]
    if arguments.kwarg:
        parameters.append((arguments.kwarg.arg, "keywords", None))
    return parameters


def parameters_of(function):
    """Returns the same for a function of the package."""
    kinds = {inspect.Parameter.POSITIONAL_OR_KEYWORD: "positional", inspect.Parameter.KEYWORD_ONLY: "keyword",
             inspect.Parameter.VAR_KEYWORD: "keywords"}
    return [(p.name, kinds[p.kind], None if p.default is p.empty else repr(p.default).replace("'", '"'))
            for p in inspect.signature(function).parameters.values()]


class StubTest(unittest.TestCase):
    def compare(self, node, found, path):
        with self.subTest(path):
            self.assertEqual(inspect.cleandoc(inspect.getdoc(found) or ""), ast.get_docstring(node) or
                             inspect.cleandoc(inspect.getdoc(found) or "") if path.endswith("__init__")
                             else ast.get_docstring(node))
            if isinstance(node, ast.ClassDef):
                self.assertTrue(inspect.isclass(found))
                for inner in node.body:
                    if isinstance(inner, (ast.FunctionDef, ast.ClassDef)):
                        self.compare(inner, getattr(found, inner.name), f"{path}.{inner.name}")
                return
            if isinstance(found, property):
                return
            expected = [(name, kind, default and default.replace("'", '"'))
                        for name, kind, default in parameters_of_stub(node)]
            self.assertEqual(parameters_of(found), expected)

    def test_stub_describes_the_package(self):
        tree = ast.parse(STUB.read_text())
        names = set()
        for node in tree.body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                names.add(node.name)
                self.compare(node, getattr(kagero, node.name), node.name)
        self.assertEqual(names | {"version"}, set(kagero.__all__))

    def test_every_public_function_is_in_the_stub(self):
        tree = ast.parse(STUB.read_text())
        scene = next(node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == "Scene")
        stubs = {node.name for node in scene.body if isinstance(node, ast.FunctionDef)}
        public = {name for name in vars(kagero.Scene) if not name.startswith("_")}
        self.assertEqual(public - stubs, set())

    def test_status_codes(self):
        tree = ast.parse(STUB.read_text())
        status = next(node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == "Status")
        codes = {node.targets[0].id: node.value.value for node in status.body if isinstance(node, ast.Assign)}
        self.assertEqual(codes, {each.name: each.value for each in kagero.Status})


if __name__ == "__main__":
    unittest.main()
