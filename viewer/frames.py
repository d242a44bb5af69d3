"""Frames of a page from the files that --output has written. docs/view.md describes their blocks."""
import base64
import os
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
from talus.series import CONTACT_FORMS, FORMS, WHAT, Series, companion, names_of_shapes, shapes_of  # noqa: E402
from talus.stored import Error, Stored, blaming  # noqa: E402

WALL, GLOBAL = 1, 2
SPHERE, POLYHEDRON, MESH, OWN = 0, 4, 5, 6  # in outputs; in pages 6 is a plane, and those from 6 on follow
NONE = 0xFFFFFFFF
MOST_CONTACTS = 50000
TYPES = {"u1": "u8", "u2": "u16", "i2": "i16", "u4": "u32", "i4": "i32", "f4": "f32", "u8": "u64"}
LARGEST = 1e150  # of a number whose square is one, too
OPTIONAL = {"orientation", "part", "asleep"}
USED = {"id", "shape", "fixed", "rank", "material", "size", "mass", "velocity", *OPTIONAL}


def series_of(output):
    """The path of an output without its extensions."""
    for end in (".series", ".hdf"):
        output = output.removesuffix(end)
    return output


def read_index(base):
    """The files and times that an index lists so far."""
    index = base + ".hdf.series"
    if not os.path.lexists(index):
        raise Error(f"there is no {index}: name what --output NAME of a run has written, NAME or NAME.hdf.series")
    return Series(index).files


def read(file, name, form, rows=None):
    """An array of a file (Stored.array), in double precision if it is of floating point: numbers below LARGEST have squares."""
    values = file.array(name, form, rows)
    return values.astype("f8", copy=False) if values.dtype.kind == "f" else values


class Blocks:
    """The arrays of a frame, one after another."""

    def __init__(self):
        self.bytes, self.where = bytearray(), {}

    def put(self, name, values, kind):
        data = np.ascontiguousarray(values, dtype="<" + kind)
        self.bytes += bytes(-len(self.bytes) % 8)
        self.where[name] = [TYPES[kind], len(self.bytes), int(data.size)]
        self.bytes += data.tobytes()


def quantised(points, smallest):
    """Positions as whole cells of their box, or as floats where cells would be coarse beside bodies:
    the values, the lower corner, the cell, the largest error."""
    if len(points) == 0:
        return points, np.zeros(3), np.ones(3), 0.0, "u2"
    lower, upper = points.min(axis=0), points.max(axis=0)
    cell = np.where(upper > lower, (upper - lower) / 65535, 1.0)
    error = float(cell[upper > lower].max(initial=0)) / 2
    if error <= 0.002 * smallest:
        return np.rint((points - lower) / cell), lower, cell, error, "u2"
    error = float(np.abs(points).max()) * 2.0**-24
    return points, np.zeros(3), np.ones(3), error, "f4"


class Converter:
    """Turns the files of a series into frames, one after another."""

    def __init__(self, base, each_contact=False):
        self.base, self.each_contact = base, each_contact
        self.rows = {}  # bytes of the unchanging properties of a body: its row
        self.forms = 0
        self.forms_of = {}  # (id, part): form
        self.previous = None
        self.notes = set()

    def note(self, text):
        if text not in self.notes:
            self.notes.add(text)
            print("view: " + text, file=sys.stderr)

    def surfaces(self, path, new, blocks):
        """Reads the faces of bodies that are seen for the first time."""
        wanted = [b for b in new if (b["shape"] in (POLYHEDRON, MESH) or b["shape"] > OWN) and b["part_key"] not in self.forms_of]
        if not wanted:
            return []
        file = companion(path, "surfaces")
        if not os.path.lexists(file):
            self.note("polyhedra and surfaces of triangles are drawn as boxes: run with --output-surfaces to see their faces")
            return []
        with Stored(file, WHAT) as f:
            ids = f.array("VTKHDF/CellData/id", "u")
            shapes = f.array("VTKHDF/CellData/shape", "u", len(ids))
            ends, corners, points = (read(f, "VTKHDF/" + k, form) for k, form in (("Offsets", "u"), ("Connectivity", "u"), ("Points", "f3")))
        if len(ends) != len(ids) + 1 or ends[0] < 0 or (ends[1:] < ends[:-1]).any() or ends[-1] > len(corners) or \
                not ((0 <= corners) & (corners < len(points))).all():
            raise Error(f"{file} is damaged: VTKHDF/Offsets and VTKHDF/Connectivity do not belong to {len(ids)} faces of {len(points)} points")
        faces = np.flatnonzero(np.isin(shapes, (POLYHEDRON, MESH)) | (shapes >= OWN))
        faces = faces[np.argsort(ids[faces], kind="stable")]
        owners, added = ids[faces], []
        for body in wanted:
            whole = (int(body["id"]), -1)
            if whole in self.forms_of:  # faces of a union belong to its first part that has some
                self.forms_of[body["part_key"]] = -2
                continue
            first, last = np.searchsorted(owners, body["id"]), np.searchsorted(owners, body["id"], "right")
            triangles = []
            for c in faces[first:last]:
                face = corners[ends[c]:ends[c + 1]]
                triangles += [(face[0], face[k], face[k + 1]) for k in range(1, len(face) - 1)]
            if not triangles:
                continue
            used, numbers = np.unique(np.array(triangles), return_inverse=True)
            local = rotated_back(body["orientation"], points[used] - body["position"])
            form, self.forms = self.forms, self.forms + 1
            blocks.put(f"form_points_{form}", local, "f4")
            blocks.put(f"form_corners_{form}", numbers, "u4")
            self.forms_of[body["part_key"]] = self.forms_of[whole] = form
            added.append(form)
        return added

    def frame(self, path, time):
        """Head and bytes of one frame. Raises Error, and then knows what it knew before."""
        known = {**vars(self), "rows": self.rows.copy(), "forms_of": self.forms_of.copy()}
        try:
            with blaming(path, "it"):
                return self.converted(path, time)
        except Error:
            vars(self).update(known)
            raise

    def converted(self, path, time):
        with Stored(path, f"{WHAT} with bodies") as f:
            step = int(f.array("VTKHDF/FieldData/step", "u", 1)[0])
            points = read(f, "VTKHDF/Points", "f3")
            there = USED - OPTIONAL | OPTIONAL.intersection(f.names("VTKHDF/PointData"))
            data = {k: read(f, f"VTKHDF/PointData/{k}", FORMS[k], len(points)) for k in sorted(there)}
            shapes_of(f, len(points))
            own = names_of_shapes(f)[OWN:]
        data["shape"] = data["shape"] + (data["shape"] >= OWN)  # with its faces, or as a box, as in pages of programs
        blocks, head, notes = Blocks(), {"step": step, "time": time}, []
        if (data["shape"] > OWN).any():
            head["shapes"] = "".join(name + "\n" for name in own)
        finite = (np.abs(points) < LARGEST).all(axis=1)
        for name in ("velocity", "size") + (("orientation",) if "orientation" in data else ()):
            finite &= (np.abs(data[name]) < LARGEST).all(axis=1)
        if not finite.all():
            bad = int(np.flatnonzero(~finite)[0])
            notes.append(f"{int((~finite).sum())} bodies are left out, because their state is not finite; the first is body "
                         f"{data['id'][bad]:#x} of rank {data['rank'][bad]} at {points[bad].tolist()}")
            self.note(f"step {step}: {notes[-1]}")
            points, data = points[finite], {k: v[finite] for k, v in data.items()}
        count = len(points)
        part = data.get("part", np.zeros(count, "u4"))
        rank = data["rank"]
        # Without a column of their own, global bodies are fixed ones of rank 0.
        order = np.lexsort((part, data["id"], data["shape"], data["fixed"]))
        # Groups of bodies with the same form follow each other.
        new = []
        keys = np.empty(count, dtype=[("id", "<u8"), ("part", "<u4"), ("shape", "u1"), ("fixed", "u1"), ("material", "<u2"),
                                      ("size", "<f4", 3), ("mass", "<f4")])
        for name, values in (("id", data["id"]), ("part", part), ("shape", data["shape"]), ("fixed", data["fixed"]),
                             ("material", data["material"]), ("size", data["size"]), ("mass", data["mass"])):
            keys[name] = values
        raw = keys.tobytes()
        width = keys.dtype.itemsize
        texts = [raw[i:i + width] for i in range(0, count * width, width)]
        for i in order:
            if texts[i] not in self.rows:
                new.append({"row": i, "id": data["id"][i], "shape": int(data["shape"][i]), "position": points[i],
                            "part_key": (int(data["id"][i]), int(part[i])),
                            "orientation": data["orientation"][i] if "orientation" in data else (1, 0, 0, 0)})
        head["forms"] = self.surfaces(path, new, blocks)
        form_of = np.array([self.forms_of.get((int(a), int(b)), -1) for a, b in zip(data["id"], part)]) if self.forms_of \
            else np.full(count, -1)
        hidden = form_of == -2
        order = np.lexsort((part, data["id"], form_of, data["shape"], data["fixed"]))
        order = order[~hidden[order]]
        if new:
            kept = [b["row"] for b in new if not hidden[b["row"]]]
            for i in kept:
                self.rows[texts[i]] = len(self.rows)
            blocks.put("new_id", data["id"][kept], "u8")
            blocks.put("new_shape", data["shape"][kept], "u1")
            blocks.put("new_flags", np.where(data["fixed"][kept] > 0, WALL, 0), "u1")
            blocks.put("new_material", data["material"][kept], "u2")
            blocks.put("new_part", part[kept], "u4")
            blocks.put("new_form", form_of[kept], "i4")
            blocks.put("new_size", data["size"][kept], "f4")
            blocks.put("new_mass", data["mass"][kept], "f4")
        rows = np.fromiter((self.rows[texts[i]] for i in order), "u4", len(order))
        if self.previous is None or not np.array_equal(rows, self.previous):
            blocks.put("rows", rows, "u4")
        self.previous = rows
        points, data = points[order], {k: v[order] for k, v in data.items()}
        smallest = float(data["size"].max(axis=1).min(initial=np.inf)) / 2
        cells, lower, cell, error, kind = quantised(points, smallest)
        blocks.put("position", cells, kind)
        head.update(lower=lower.tolist(), cell=cell.tolist(), position_error=error, bodies=int(count), ranks=int(rank.max(initial=0)) + 1)
        solid = data["shape"] != SPHERE
        if solid.any():
            turn = data["orientation"][solid][:, [1, 2, 3, 0]] if "orientation" in data else np.tile((0, 0, 0, 1), (solid.sum(), 1))
            blocks.put("orientation", np.rint(turn * 32767), "i2")
        speed_cell = max(float(np.abs(data["velocity"]).max(initial=0)) / 32767, 1e-30)
        blocks.put("velocity", np.rint(data["velocity"] / speed_cell), "i2")
        speed = np.linalg.norm(data["velocity"], axis=1)
        free = data["fixed"] == 0
        if free.any():
            half = data["size"][free].max(axis=1, keepdims=True) / 2
            head["box"] = [*(points[free] - half).min(axis=0).tolist(), *(points[free] + half).max(axis=0).tolist()]
        head.update(speed_cell=speed_cell, speed_max=float(speed[free].max(initial=0)))
        if head["ranks"] > 1:
            blocks.put("rank", data["rank"], "u2")
        if "asleep" in data and data["asleep"].any():
            blocks.put("asleep", data["asleep"], "u1")
        values = {"bodies": int(np.unique(data["id"][free]).size), "max_speed": head["speed_max"]}
        self.contacts(path, data, points, lower, cell, kind, blocks, head, values)
        head["values"] = values
        if notes:
            head["notes"] = notes
        head["blocks"] = blocks.where
        return head, bytes(blocks.bytes)

    def contacts(self, path, data, points, lower, cell, kind, blocks, head, values):
        file = companion(path, "contacts")
        if not os.path.lexists(file):
            return
        with Stored(file, WHAT) as f:
            rows = len(f.array("VTKHDF/CellData/id_a", "u"))
            c = {k: read(f, f"VTKHDF/CellData/{k}", CONTACT_FORMS[k], rows) for k in ("id_a", "id_b", "point", "force", "normal_force")}
        force = np.linalg.norm(c["force"], axis=1)
        good = np.flatnonzero((force < LARGEST) & (np.abs(c["point"]) < LARGEST).all(axis=1) & (np.abs(c["normal_force"]) < LARGEST))
        head["contacts_of"] = int(len(good))
        values["contacts"] = int(len(good))
        if len(good) == 0 or len(points) == 0:
            return
        values["normal_force_mean"] = float(c["normal_force"][good].mean())
        values["normal_force_max"] = float(c["normal_force"][good].max())
        head["force_mean"] = float(force[good].mean())
        # The part of a union with the lowest index stands for it.
        order = np.argsort(data["id"], kind="stable")
        sorted_ids = data["id"][order]

        def index(ids):
            at = np.minimum(np.searchsorted(sorted_ids, ids), len(order) - 1)
            return np.where(sorted_ids[at] == ids, order[at], NONE)
        # The sum of the sizes of the contact forces on each body; its parts have that of the whole.
        sums, touching = np.zeros(len(order) + 1), np.zeros(len(order) + 1, dtype="i8")
        for side in ("id_a", "id_b"):
            at = np.minimum(index(c[side][good]), len(order))
            np.add.at(sums, at, force[good])
            np.add.at(touching, at, 1)
        whole = index(data["id"])
        sums, touching, wall = sums[whole], touching[whole], data["fixed"] > 0
        cells = [max(float(sums[of].max(initial=0)) / 65535, 1e-300) for of in (~wall, wall)]
        blocks.put("force", np.minimum(np.rint(sums / np.where(wall, cells[1], cells[0])), 65535), "u2")
        blocks.put("touching", np.minimum(touching, 255), "u1")
        head.update(body_force_cell=cells[0], wall_force_cell=cells[1])
        if not self.each_contact:
            return
        good = good[np.lexsort((c["id_b"][good], c["id_a"][good], -force[good]))][:MOST_CONTACTS]
        blocks.put("contact_a", index(c["id_a"][good]), "u4")
        blocks.put("contact_b", index(c["id_b"][good]), "u4")
        place = (c["point"][good] - lower) / cell
        blocks.put("contact_point", place if kind == "f4" else np.clip(np.rint(place), 0, 65535), kind)
        force_cell = max(float(force[good].max()) / 65535, 1e-30)
        blocks.put("contact_force", np.rint(force[good] / force_cell), "u2")
        head["force_cell"] = force_cell


def rotated_back(q, points):
    """Points in the frame of a body with the orientation q = w, x, y, z."""
    w, v = float(q[0]), -np.asarray(q[1:], dtype=float)
    return points + 2 * np.cross(v, np.cross(v, points) + w * points)


def text_of(data):
    return base64.b64encode(data).decode("ascii")
