"""Chain of joints from a base link to a tip link of a document."""

from collections import defaultdict

from .elements import Document, Kind, UrdfJoint

_MOST_NAMES = 12  # tips that a message lists


def chain(document: Document, base: str | None, tip: str | None) -> tuple[UrdfJoint, ...]:
    """Joints from the base to the tip; by default from the root to the only end of the tree.

    Raises:
        ValueError: the file is no tree, the links are not on one branch, several branches and no
            tip, a joint on the chain that a serial arm cannot have, or none that moves.
    """
    parents = _parents(document)
    for end in filter(None, (base, tip)):
        if end not in document.links:
            raise ValueError(f"link {end!r} is not in the file; links: {_listed(document.links)}")
    root = _root(document, parents)
    tip = tip or _only_end(document, base or root)
    joints, link = [], tip
    while link != (base or root):
        if link not in parents:
            raise ValueError(f"no chain leads from link {base!r} to link {tip!r}")
        joints.append(parents[link])
        link = parents[link].parent
    joints.reverse()
    for joint in joints:
        _check(joint)
    if all(joint.kind is Kind.FIXED for joint in joints):
        raise ValueError(f"no joint moves between link {link!r} and link {tip!r}")
    return tuple(joints)


def children(document: Document) -> dict[str, list[UrdfJoint]]:
    """Joints by the name of their parent link."""
    found = defaultdict(list)
    for joint in document.joints:
        found[joint.parent].append(joint)
    return found


def _parents(document: Document) -> dict[str, UrdfJoint]:
    """Joint by the name of its child link; every link has one parent at most, and no loop."""
    parents: dict[str, UrdfJoint] = {}
    for joint in document.joints:
        if joint.child in parents:
            other = parents[joint.child].name
            raise ValueError(f"link {joint.child!r} closes a loop: {other!r} and {joint.name!r}")
        parents[joint.child] = joint
    for start in document.links:
        link, steps = start, 0
        while link in parents:
            link, steps = parents[link].parent, steps + 1
            if steps > len(parents):
                raise ValueError(f"link {start!r} is in a loop: it is below itself")
    return parents


def _root(document: Document, parents: dict[str, UrdfJoint]) -> str:
    roots = [link for link in document.links if link not in parents]
    if len(roots) > 1:
        raise ValueError(f"must have one link without a parent, got {_listed(roots)}")
    return roots[0]


def _only_end(document: Document, base: str) -> str:
    below, ends, links = children(document), [], [base]
    while links:
        link = links.pop()
        links += [joint.child for joint in below[link]]
        if not below[link]:
            ends.append(link)
    if len(ends) > 1:
        names = _listed(sorted(ends))
        raise ValueError(f"has several branches; choose a tip link, as in FILE.urdf#TIP: {names}")
    return ends[0]


def _check(joint: UrdfJoint) -> None:
    if joint.fault is not None:
        raise ValueError(joint.fault)
    if joint.mimics is not None:
        raise ValueError(
            f"joint {joint.name!r} mimics {joint.mimics!r}; joints must be independent"
        )
    if joint.kind in (Kind.FLOATING, Kind.PLANAR, Kind.BALL):
        allowed = "revolute, continuous, prismatic, fixed"
        kind = joint.kind.value
        raise ValueError(f"joint {joint.name!r} is {kind}; a chain may have joints: {allowed}")


def _listed(names) -> str:
    names = list(names)
    more = f" and {len(names) - _MOST_NAMES} more" if len(names) > _MOST_NAMES else ""
    return ", ".join(names[:_MOST_NAMES]) + more
