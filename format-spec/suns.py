"""M57 of SPEC.md: a list of suns' directions, and triangles that cover the sphere exactly once."""
import math

from faults import need

dot = lambda a, b: a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
def determinant(a, b, c):
    return dot(a, (b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]))
def solid_angle(a, b, c):
    """Van Oosterom and Strackee 1983, eq. 8."""
    u, v, w = (math.sqrt(dot(p, p)) for p in (a, b, c))
    across = u * v * w + dot(a, b) * w + dot(a, c) * v + dot(b, c) * u
    return 2 * math.atan2(determinant(a, b, c), across)
def is_list(value):
    """Whether it is a list of directions, sound or not."""
    return isinstance(value, dict) and value.get("kind") == "directions"
def check(suns):
    def rule(holds, what):
        need(holds, 5003, f"metadata.light.suns.{what}")
    def threes(name, kinds):
        rows = suns[name]
        rule(isinstance(rows, list) and all(isinstance(row, list) and len(row) == 3 for row in rows), name)
        rule(all(type(item) in kinds for row in rows for item in row), name)
        return rows
    rule(set(suns) == {"kind", "directions", "triangles"}, "members")
    directions, triangles = threes("directions", (int, float)), threes("triangles", (int,))
    rule(4 <= len(directions) <= 255, "directions: number")
    rule(all(abs(math.sqrt(dot(s, s)) - 1) <= 1e-6 for s in directions), "directions: length")
    rule(all(0 <= i < len(directions) for corners in triangles for i in corners), "triangles: index")
    rule(all(a < b and a < c and b != c for a, b, c in triangles), "triangles: corners")
    rule(all(a < b for a, b in zip(triangles, triangles[1:])), "triangles: order")
    corners = [[directions[i] for i in three] for three in triangles]
    rule(all(determinant(*three) >= 1e-6 for three in corners), "triangles: determinant")
    edges = [edge for a, b, c in triangles for edge in ((a, b), (b, c), (c, a))]
    known = set(edges)
    rule(len(known) == len(edges) and all((b, a) in known for a, b in edges), "triangles: edges")
    rule({i for three in triangles for i in three} == set(range(len(directions))), "directions: no corner")
    rule(sum(solid_angle(*three) for three in corners) < 6 * math.pi, "triangles: solid angles")
    return True
