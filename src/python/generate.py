# SPDX-License-Identifier: Apache-2.0
"""Declarations of the public headers for ctypes: generate.py INCLUDE_DIR OUTPUT.py

The headers have one style, and this reads that style alone: typedefs of structs, enumerations, opaque objects and
functions, exported functions, default initializers. Whatever it does not know ends the build with its text, so that
no declaration is lost unseen. Comments become the docstrings of the package.
"""
import os
import re
import sys

SCALARS = {
    "bool": "c_bool", "char": "c_char", "int": "c_int", "unsigned": "c_uint", "float": "c_float", "double": "c_double",
    "size_t": "c_size_t", "uint8_t": "c_uint8", "int32_t": "c_int32", "uint32_t": "c_uint32", "int64_t": "c_int64",
    "uint64_t": "c_uint64",
}
NAMES = {"NULL": "None", "true": "True", "false": "False", "HUGE_VAL": "math.inf", "UINT64_MAX": "0xffffffffffffffff"}


class Headers:
    """Everything that the headers declare, in their order, as lines of Python."""

    def __init__(self, folder):
        self.folder = folder
        self.seen = set()
        self.lines = []
        self.functions = []
        self.tables = []
        self.structs = set()
        self.opaque = set()
        self.enums = {}
        self.callbacks = set()
        self.read("nephos/nephos.h")

    # ---- Texts ----

    def read(self, name):
        if name in self.seen:
            return
        self.seen.add(name)
        with open(os.path.join(self.folder, name), encoding="utf-8") as file:
            text = file.read().replace("\\\n", " ")
        text = re.sub(r"#ifdef __cplusplus\n.*?#endif\n", "", text, flags=re.S)
        self.declare_all(name, text)

    def declare_all(self, name, text):
        """Walks a header: comments, directives, and statements up to a semicolon outside of braces."""
        doc, at = "", 0
        while at < len(text):
            if text[at].isspace():
                at += 1
            elif text.startswith("/*", at):
                end = text.index("*/", at) + 2
                doc = clean_comment(text[at:end]) if text.startswith("/**", at) else ""
                at = end
            elif text[at] == "#":
                end = text.find("\n", at)
                self.obey(text[at:end], doc)
                doc, at = "", end
            else:
                end = end_of_statement(text, at)
                self.declare(name, text[at:end].strip(), doc)
                doc, at = "", end + 1

    def obey(self, line, doc):
        include = re.match(r"#include <(nephos/\w+\.h)>", line)
        if include:
            self.read(include[1])
        define = re.match(r"#define (\w+)(\(\w+\))?\s*(.*)", line)
        if not define or not define[3] or define[1] in ("NEPH_API", "NEPH_NODISCARD"):
            return
        name, value = define[1], define[3].strip()
        if name == "NEPH_RESULTS":
            self.enums["neph_result"] = [(n, v, t) for n, v, t in re.findall(r'X\((\w+), (\d+), "([^"]*)"\)', value)]
        elif re.fullmatch(r"NEPH_\w+_DEFAULT", name):
            struct = re.search(r"\.struct_size = sizeof\((\w+)\)", value)[1]
            self.lines.append("%s = %s.default = %s" % (name, struct, Initializer(value).read()))
        elif not define[2]:
            self.lines.append("%s = %s" % (name, Initializer(value).read()))

    # ---- Statements ----

    def declare(self, header, statement, doc):
        if statement.startswith("NEPH_API extern"):
            return self.declare_table(statement)
        if statement.startswith("NEPH_API"):
            return self.declare_function(header, statement, doc)
        typedef = re.match(r"typedef (struct|enum) (\w+) \{(.*)\} \2$", statement, re.S)
        if typedef:
            declare = self.declare_struct if typedef[1] == "struct" else self.declare_enum
            return declare(typedef[2], typedef[3], doc)
        opaque = re.fullmatch(r"typedef struct (\w+) \1|struct (\w+)", statement)
        if opaque:
            return self.declare_opaque(opaque[1] or opaque[2], doc)
        callback = re.fullmatch(r"typedef (.+?)\(\*(\w+)\)\((.*)\)", statement, re.S)
        if callback:
            return self.declare_callback(callback[2], callback[1], callback[3], doc)
        constants = re.match(r"enum \{(.*)\}$", statement, re.S)
        if not constants:
            raise SystemExit("%s: no rule of generate.py reads: %s" % (header, statement))
        for name, value, _ in list_constants(constants[1]):
            self.lines.append("%s = %s" % (name, value))

    def declare_opaque(self, name, doc):
        if name not in self.opaque:
            self.lines.append("class %s(c_void_p):\n    pass" % name)
        self.opaque.add(name)
        self.lines.append("%s.__doc__ = %r" % (name, doc))

    def declare_enum(self, name, body, doc):
        rows = self.enums.get(name) or list_constants(body)
        self.enums[name] = rows
        names = [row[0] for row in rows if not row[0].endswith("_COUNT")]
        prefix = name.upper() + "_"
        if not all(row.startswith(prefix) for row in names):
            prefix = os.path.commonprefix(names)
            prefix = prefix[: prefix.rindex("_") + 1]
        self.lines += ["%s = %s" % (n, v) for n, v, _ in rows]
        words = ", ".join("%r: %s" % (n[len(prefix):].lower(), n) for n, _, _ in rows if not n.endswith("_COUNT"))
        self.lines.append("ENUMS[%r] = {%s}" % (name, words))
        self.lines.append("DOCS[%r] = %r" % (name, doc))

    def declare_callback(self, name, result, arguments, doc):
        types = [self.map_type(result)] + [self.map_declarator(a)[1] for a in split_arguments(arguments)]
        self.callbacks.add(name)
        self.lines.append("%s = CFUNCTYPE(%s)" % (name, ", ".join(types)))
        self.lines.append("DOCS[%r] = %r" % (name, doc))

    def declare_struct(self, name, body, doc):
        fields, docs, enums = [], {}, {}
        for text, comment in list_members(body):
            first, *others = text.split(",")
            base = re.match(r"(.*?)[\s*]*\w+[\[\]\w]*$", first, re.S)[1]
            for declarator in [first] + [base + " " + other.strip() for other in others]:
                field, kind, plain = self.map_declarator(declarator)
                fields.append((field, kind))
                docs[field] = comment
                if plain in self.enums:
                    enums[field] = plain
        self.structs.add(name)
        rows = ", ".join("(%r, %s)" % field for field in fields)
        self.lines.append(
            "class %s(Structure):\n    %r\n    _fields_ = [%s]\n    docs = %r\n    enums = %r\n    default = {}"
            % (name, doc, rows, docs, enums))

    def declare_function(self, header, statement, doc):
        match = re.fullmatch(r"NEPH_API (.*?)(\w+)\((.*)\)(?: NEPH_NODISCARD)?", statement, re.S)
        arguments = [] if match[3] == "void" else [self.map_declarator(a)[1] for a in split_arguments(match[3])]
        row = "(%s, (%s))" % (self.map_type(match[1]), "".join(a + ", " for a in arguments))
        self.functions.append((match[2], row, doc, header))

    def declare_table(self, statement):
        match = re.fullmatch(r"NEPH_API extern const (\w+) (\w+)\[(\w+)\]", statement)
        self.tables.append("    %r: %s * %s," % (match[2], match[1], match[3]))

    # ---- Types ----

    def map_declarator(self, text):
        """Name, ctypes type and plain C type of one declarator. Arrays of parameters are pointers to ctypes too."""
        text = " ".join(text.split())
        match = re.fullmatch(r"(.*?)(\w+)((?:\[\w+\])*)", text)
        kind = self.map_type(match[1])
        for size in reversed(re.findall(r"\[(\w+)\]", match[3])):
            kind = "%s * %s" % (kind, size)
        return match[2], kind, match[1].strip()

    def map_type(self, text):
        tag = re.search(r"\bstruct (\w+)", text)
        if tag and tag[1] not in self.opaque:
            self.declare_opaque(tag[1], "")
        text = re.sub(r"\b(struct|extern)\b", "", text)
        depth = text.count("*")
        is_const = text.lstrip().startswith("const")
        base = re.sub(r"\bconst\b|\*", "", text).strip()
        if base in ("void", "char") and depth:
            kind = "c_char_p" if base == "char" and is_const else "c_void_p"
            depth -= 1
        elif base == "void":
            return "None"
        elif base in self.opaque:
            kind, depth = base, depth - 1
        elif base in SCALARS:
            kind = SCALARS[base]
        elif base in self.enums:
            kind = "c_int"
        elif base in self.structs or base in self.callbacks:
            kind = base
        else:
            raise SystemExit("generate.py does not know the type of: " + text)
        return "POINTER(" * depth + kind + ")" * depth

    def write(self, path):
        with open(path, "w", encoding="utf-8") as file:
            file.write("# SPDX-License-Identifier: Apache-2.0\n# Written by generate.py from the headers of nephos.\n")
            file.write("import math\nfrom ctypes import *\n\nENUMS = {}\nDOCS = {}\n\n")
            file.write("\n".join(self.lines) + "\n\nFUNCTIONS = {\n")
            file.write("".join("    %r: %s,\n" % (name, row) for name, row, _, _ in self.functions))
            file.write("}\n\nTABLES = {\n" + "\n".join(self.tables) + "\n}\n\n")
            file.write("DOCS.update({\n")
            file.write("".join("    %r: %r,\n" % (name, doc) for name, _, doc, _ in self.functions) + "})\n")
            file.write("HEADERS = {%s}\n" % ", ".join("%r: %r" % (n, h) for n, _, _, h in self.functions))


class Initializer:
    """An initializer of C as an expression of Python: members in a dict, arrays in a list."""

    def __init__(self, text):
        self.tokens = re.findall(r'"[^"]*"|\.[A-Za-z_]\w*|[A-Za-z_]\w*|[-+]?[\d.]+(?:[eE][-+]?\d+)?\w*|\S', text)

    def read(self):
        if self.tokens[0] == "{":
            return self.read_braces()
        parts = []
        while self.tokens and self.tokens[0] not in ",}":
            parts.append(self.read_token())
        return "".join(parts)

    def read_braces(self):
        self.tokens.pop(0)
        members, values = [], []
        while self.tokens[0] != "}":
            if self.tokens[0][0] == "." and not self.tokens[0][1].isdigit():
                name = self.tokens.pop(0)[1:]
                self.tokens.pop(0)
                members.append("%r: %s" % (name, self.read()))
            else:
                values.append(self.read())
            if self.tokens[0] == ",":
                self.tokens.pop(0)
        self.tokens.pop(0)
        return "{%s}" % ", ".join(members) if members else "[%s]" % ", ".join(values)

    def read_token(self):
        token = self.tokens.pop(0)
        if token == "UINT64_C":
            value = self.tokens[1]
            del self.tokens[:3]
            return value
        if token == "sizeof":
            struct = self.tokens[1]
            del self.tokens[:3]
            return "sizeof(%s)" % struct
        if token[0] == '"':
            return "b" + token
        if token.startswith("0x"):
            return token.rstrip("uUlL")
        if token.startswith("neph_"):
            return repr("@" + token) # a table of the library
        return NAMES.get(token, token)


def end_of_statement(text, at):
    depth = 0
    while True:
        if text.startswith("/*", at):
            at = text.index("*/", at) + 1
        elif text[at] in "{(":
            depth += 1
        elif text[at] in "})":
            depth -= 1
        elif text[at] == ";" and depth == 0:
            return at
        at += 1


def clean_comment(text):
    """The text of a comment without its stars; paragraphs and parameters stay on lines of their own."""
    text = re.sub(r"^/\*+<?|\*/$", "", text)
    lines = [re.sub(r"^\s*\* ?", "", line).strip() for line in text.split("\n")]
    out = ""
    for line in lines:
        if not line:
            out += "\n\n" if out and not out.endswith("\n") else ""
        elif line.startswith("@"):
            out += ("\n" if out and not out.endswith("\n") else "") + line
        else:
            out += (" " if out and not out.endswith("\n") else "") + line
    return out.strip()


def list_members(body):
    """(declaration, comment) of each member of a struct; the comment stands behind it or before it."""
    members, pending = [], ""
    for token in re.finditer(r"/\*.*?\*/|[^;/]+;", body, re.S):
        text = token[0].strip()
        if text.startswith("/**<"):
            members[-1][1] = clean_comment(text)
        elif text.startswith("/*"):
            pending = clean_comment(text)
        else:
            members.append([" ".join(text[:-1].split()), pending])
            pending = ""
    return members


def list_constants(body):
    """(name, value, comment) of an enumeration; a value that is not given is one more than the last."""
    rows, value = [], -1
    for name, given in re.findall(r"(\w+)(?:\s*=\s*(\w+))?\s*(?:,|$)", re.sub(r"/\*.*?\*/", "", body, flags=re.S).strip()):
        value = int(given, 0) if given else value + 1
        rows.append((name, str(value), ""))
    return rows


def split_arguments(text):
    return [part for part in " ".join(text.split()).split(", ") if part]


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    Headers(sys.argv[1]).write(sys.argv[2])
