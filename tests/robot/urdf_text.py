"""Small URDF texts for the tests: links come from the joints."""

from __future__ import annotations

from collections.abc import Iterable


def joint(name: str, parent: str, child: str, kind: str = "revolute", inside: str = "") -> str:
    """One <joint>; with limits and z as axis unless `inside` gives its own."""
    inside = inside or '<axis xyz="0 0 1"/><limit lower="-1" upper="2" velocity="3"/>'
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


def robot(joints: Iterable[str], links: Iterable[str] = ()) -> str:
    """A <robot>, one joint per line from line 2 on, with every link that the joints name."""
    body = list(joints)
    words = "".join(body).replace("child link", "parent link").split('parent link="')[1:]
    names = dict.fromkeys([*links, *(word.split('"')[0] for word in words)])
    declared = "".join(f'<link name="{name}"/>' for name in names)
    return "\n".join(['<robot name="test">', *body, declared, "</robot>"])


def chain(count: int, prefix: str = "", start: str = "base", kind: str = "revolute") -> list[str]:
    """Joints j1 … jn in a row: start -> l1 -> … -> ln."""
    links = [start, *(f"{prefix}l{i + 1}" for i in range(count))]
    return [joint(f"{prefix}j{i + 1}", links[i], links[i + 1], kind) for i in range(count)]
