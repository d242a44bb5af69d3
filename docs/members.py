#!/usr/bin/env python3
"""Writes docs/members.md, all members of what users hold in their hands, and
include/talus/core/field_names.hpp, the sentences that list the fields of options where braces have a
wrong one. Both follow from the headers; `./dev docs --sheet` runs this.
  members.py ROOT [--check]      --check: only says what is out of date, or lacks a docstring
"""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
include = root / "include" / "talus"

# What is on the sheet: headings, and below them (header, class, how it is shown) or (header, [functions]).
SHEET = [
    ("Worlds", "`world` in a set-up; *collective* functions are called by all ranks.", [
        ("world/world.hpp", "world", "world<Scenario>"),
        ("world/world.hpp", "every", "every"),
        ("world/checkpoints.hpp", "simulation", "simulation"),
        ("world/unit_names.hpp", "unit_names", "unit_names"),
        ("state/body_count.hpp", "body_count", "body_count"),
        ("state/response_state.hpp", "convergence", "convergence"),
        ("constraint/solver_settings.hpp", "solver_settings", "solver_settings"),
    ]),
    ("Bodies", "What is added, what `for_each_local` and `world[handle]` give, and shapes.", [
        ("body/body.hpp", "body", "body<Shape>"),
        ("body/body.hpp", "handle", "handle<Shape>"),
        ("world/view.hpp", "body_view", "body_view<Scenario, Shape>"),
        ("core/math.hpp", ["rotation", "rotated"]),
        ("shape/sphere.hpp", "sphere", "sphere"),
        ("shape/box.hpp", "box", "box"),
        ("shape/capsule.hpp", "capsule", "capsule"),
        ("shape/cylinder.hpp", "cylinder", "cylinder"),
        ("shape/ellipsoid.hpp", "ellipsoid", "ellipsoid"),
        ("shape/superellipsoid.hpp", "superellipsoid", "superellipsoid"),
        ("shape/plane.hpp", "plane", "plane"),
        ("shape/convex_polyhedron.hpp", "convex_polyhedron", "convex_polyhedron"),
        ("shape/union_of.hpp", "union_of", "union_of<Shapes...>"),
        ("shape/triangle_mesh.hpp", "triangle_mesh", "triangle_mesh"),
        ("body/motion.hpp", "*", ""),
        ("body/servo.hpp", "servo", "servo"),
        ("shape/surfaces.hpp", "*", ""),
        ("shape/surfaces.hpp", ["triangles_of_revolution", "surface_of_revolution", "tube_surface", "cone_surface"]),
        ("io/stl.hpp", ["read_stl"]),
    ]),
    ("Contacts", "What touches, and with which force.", [
        ("world/each_contact.hpp", "loaded_contact", "loaded_contact"),
        ("contact/contact_geometry.hpp", "contact_geometry", "contact_geometry"),
        ("world/each_contact.hpp", ["for_each_contact"]),
        ("observe/force.hpp", ["contact_force", "contact_torque"]),
        ("observe/loads.hpp", "contact_load", "contact_load"),
        ("observe/loads.hpp", ["contact_forces"]),
        ("observe/coordination.hpp", "*", ""),
        ("observe/coordination.hpp", ["*"]),
    ]),
    ("Joints", "What `world.join(a, b, kind)` takes and gives: see [joints](joints.md).", [
        ("world/joint_handle.hpp", "joint_handle", "joint_handle<Scenario, Kind>"),
        ("constraint/ball_joint.hpp", "ball_joint", "ball_joint"),
        ("constraint/fixed_joint.hpp", "fixed_joint", "fixed_joint"),
        ("constraint/weld.hpp", "weld", "weld"),
        ("constraint/hinge.hpp", "hinge", "hinge"),
        ("constraint/slider.hpp", "slider", "slider"),
        ("constraint/cylindrical_joint.hpp", "cylindrical_joint", "cylindrical_joint"),
        ("constraint/universal_joint.hpp", "universal_joint", "universal_joint"),
        ("constraint/rod.hpp", "rod", "rod"),
        ("constraint/rod.hpp", "rope", "rope"),
        ("constraint/point_on_plane.hpp", "point_on_plane", "point_on_plane"),
        ("constraint/gear.hpp", "gear", "gear"),
        ("constraint/joint_axis.hpp", "joint_limits", "joint_limits"),
        ("constraint/joint_axis.hpp", "torque_motor", "torque_motor"),
        ("constraint/joint_axis.hpp", "force_motor", "force_motor"),
        ("constraint/joint_axis.hpp", "joint_spring", "joint_spring"),
        ("world/each_joint.hpp", "joint_in_world", "joint_in_world"),
        ("world/each_joint.hpp", ["for_each_joint"]),
    ]),
    ("Materials", "Units are those of the scene: see [units](policies/contact.md#units).", [
        ("body/material.hpp", "material", "material"),
        ("body/material.hpp", "pair_material", "pair_material"),
        ("body/material.hpp", "pair_rules", "pair_rules"),
        ("body/material.hpp", "material_table", "material_table"),
    ]),
    ("Options", "What `run` reads from the command line, and the settings of single functions.", [
        ("scene/options.hpp", "options", "options"),
        ("world/picture.hpp", "picture", "picture"),
        ("scene/inflow.hpp", "inflow", "inflow"),
        ("scene/inflow.hpp", "inserted", "inserted"),
        ("scene/outflow.hpp", "removed", "removed"),
        ("features/sleeping/sleep_state.hpp", "sleep_settings", "sleep_settings"),
        ("features/balancing/balance_state.hpp", "balance_settings", "balance_settings"),
        ("observe/fields.hpp", "field_grid", "field_grid"),
    ]),
    ("Decompositions", "`world.decompose({...}, reach{d})`; chosen by `decomposition<...>`.", [
        ("parallel/reach.hpp", "reach", "reach"),
        ("parallel/grid.hpp", "grid", "grid<X, Y, Z>"),
        ("parallel/rectilinear.hpp", "rectilinear", "rectilinear<X, Y, Z>"),
        ("parallel/bisection.hpp", "bisection", "bisection<N>"),
        ("parallel/slabs.hpp", "slabs", "slabs<N>"),
        ("parallel/ring.hpp", "ring", "ring<N>"),
        ("parallel/hexagonal.hpp", "hexagonal", "hexagonal<R>"),
    ]),
    ("Places and random numbers", "For `world.fill`.", [
        ("scene/lattice.hpp", "*", ""),
        ("scene/region.hpp", "box_region", "box_region"),
        ("scene/region.hpp", "vertical_cylinder", "vertical_cylinder"),
        ("scene/region.hpp", "ball_region", "ball_region"),
        ("scene/ring.hpp", "ring_of", "ring_of"),
        ("scene/site.hpp", "site", "site"),
        ("scene/sizes.hpp", "uniform_size", "uniform_size"),
        ("scene/sizes.hpp", "lognormal_size", "lognormal_size"),
        ("core/random.hpp", "random_stream", "random_stream"),
    ]),
    ("Observers", "Functions of a world; `<talus/observe.hpp>` has those of fields and flow.", [
        ("observe/motion.hpp", "*", ""), ("observe/motion.hpp", ["*"]),
        ("observe/loads.hpp", "body_reading", "body_reading"),
        ("observe/loads.hpp", ["measure_body"]),
        ("observe/tables.hpp", "data_table", "data_table"),
        ("observe/tables.hpp", ["body_table", "contact_table"]),
        ("observe/penetration.hpp", "*", ""), ("observe/penetration.hpp", ["*"]),
        ("observe/residual.hpp", ["*"]),
        ("observe/energy.hpp", ["*"]),
        ("observe/joints.hpp", "*", ""), ("observe/joints.hpp", ["*"]),
        ("observe/momentum.hpp", ["*"]),
        ("observe/overlaps.hpp", ["*"]),
        ("observe/digest.hpp", ["*"]),
        ("observe/run_ends.hpp", "*", ""), ("observe/run_ends.hpp", ["*"]),
        ("observe/critical_dt.hpp", ["*"]),
        ("observe/queries.hpp", "ray", "ray"),
        ("observe/queries.hpp", "shape_path", "shape_path"),
        ("observe/asked_bodies.hpp", "query_filter", "query_filter"),
        ("observe/asked_bodies.hpp", "query_hit", "query_hit"),
        ("observe/queries.hpp", ["cast_rays", "cast_rays_through", "cast_shape", "cast_shape_through", "find_overlaps",
                                 "nearest_bodies", "bodies_within", "handle_of", "shape_name"]),
        ("observe/fields.hpp", "coarse_fields", "coarse_fields"),
        ("observe/fields.hpp", ["measure_fields"]),
        ("observe/flow.hpp", "*", ""),
        ("scene/inflow.hpp", ["insert_by_rate"]),
        ("scene/outflow.hpp", ["*"]),
        ("scene/pictures.hpp", ["take_pictures"]),
        ("scene/fluid.hpp", ["*"]),
        ("scene/force_field.hpp", ["*"]),
    ]),
]

# Structs that are written as braces, {.field = ...}: name of the sentence, header, struct, and what is asked.
FIELDS = [
    ("material", "body/material.hpp", "material", "world.material({...})"),
    ("pair_material", "body/material.hpp", "pair_material", "world.material_pair(a, b, {...})"),
    ("pair_rules", "body/material.hpp", "pair_rules", "world.pair_rules({...})"),
    ("simulation", "world/checkpoints.hpp", "simulation", "world.simulate({...})"),
    ("unit_names", "world/unit_names.hpp", "unit_names", "world.units({...})"),
    ("balance_settings", "features/balancing/balance_state.hpp", "balance_settings", "world.balance({...})"),
    ("sleep_settings", "features/sleeping/sleep_state.hpp", "sleep_settings", "world.sleeping({...})"),
    ("servo", "body/servo.hpp", "servo", "world.hold_force(body, {...})"),
    ("inflow", "scene/inflow.hpp", "inflow", "insert_by_rate(world, {...}, region, make)"),
    ("picture", "world/picture.hpp", "picture", "take_pictures(world, options, {...})"),
    ("field_grid", "observe/fields.hpp", "field_grid", "measure_fields(world, {...})"),
    ("grid", "parallel/grid.hpp", "grid", "world.decompose({...}) of a grid"),
    ("rectilinear", "parallel/rectilinear.hpp", "rectilinear", "world.decompose({...}) of a rectilinear grid"),
    ("bisection", "parallel/bisection.hpp", "bisection", "world.decompose({...}) of a bisection"),
    ("slabs", "parallel/slabs.hpp", "slabs", "world.decompose({...}) of slabs"),
    ("ring", "parallel/ring.hpp", "ring", "world.decompose({...}) of a ring"),
    ("hexagonal", "parallel/hexagonal.hpp", "hexagonal", "world.decompose({...}) of hexagonal cells"),
]

# Structs that are written by name, in inline namespaces that list their fields (core/refused_fields.hpp).
NAMED = [("body/material.hpp", "material"), ("body/body.hpp", "body"),
         *[(f"constraint/{name}.hpp", name) for name in
           ("ball_joint", "fixed_joint", "weld", "hinge", "slider", "cylindrical_joint", "universal_joint", "point_on_plane",
            "gear", "strut")],
         ("constraint/rod.hpp", "rod"), ("constraint/rod.hpp", "rope"),
         *[("constraint/joint_axis.hpp", name) for name in ("joint_limits", "torque_motor", "force_motor", "joint_spring")],
         *[("body/motion.hpp", name) for name in ("rigid_displacement", "rigid_velocity", "surface_velocity", "oscillation",
                                                  "turning", "gliding", "belt")]]

POLICIES = ["scenario", "bodies", "hard_contact", "soft_contact", "solver", "broad_phase", "integrator", "decomposition",
            "transport", "precision", "features", "joints"]

# For those who extend the library, not for those who use what it has.
INSIDE = {"pack", "bending_along", "level", "resolve", "half_extents", "support", "describe", "for_each_in", "extent", "as_grid", "reach_from",
          "mesh", "tree", "state", "frame", "operator=", "add_body", "decomposition_lower", "reach_of_axis"}
INSIDE_OF = {"convergence": {"add", "add_residual"}, "body_count": {"add", "remove"},
             "simple_cubic": {"step", "shift"}, "body_centred_cubic": {"step", "shift"},
             "face_centred_cubic": {"step", "shift"}, "hexagonal_close_packed": {"step", "shift"}}

OPEN, CLOSE = "([{", ")]}"


def skip(text, i):
    """Behind the string, character or comment that begins at i, or i."""
    if text.startswith("//", i):
        end = text.find("\n", i)
        return len(text) if end < 0 else end
    if text[i] in "\"'" and not (text[i] == "'" and text[i - 1].isalnum()):
        quote, i = text[i], i + 1
        while text[i] != quote:
            i += 2 if text[i] == "\\" else 1
        return i + 1
    return i


def closing(text, i):
    """Behind the bracket that closes the one at i."""
    depth = 0
    while i < len(text):
        j = skip(text, i)
        if j > i:
            i = j
            continue
        depth += (text[i] in OPEN) - (text[i] in CLOSE)
        i += 1
        if depth == 0:
            return i
    raise SystemExit("unbalanced brackets")


def bare(declaration):
    """Without template arguments, in which brackets and commas mean nothing here."""
    declaration = declaration.replace("->", "  ").replace(">=", "  ")
    while True:
        less = re.sub(r"<[^<>()]*(\([^()]*\))?[^<>()]*>", lambda m: " " * len(m[0]), declaration)
        if less == declaration:
            return declaration
        declaration = less


def declarations(text):
    """(docstring, declaration, body or None) of what stands directly in this text, with access."""
    i, doc, public = 0, [], True
    while i < len(text):
        if text[i].isspace() or text[i] == ";":
            i += 1
        elif text.startswith("///", i):
            end = skip(text, i)
            doc.append(text[i + 3:end].strip())
            i = end
        elif text.startswith("//", i) or text[i] == "#":
            end = text.find("\n", i)
            while text[end - 1] == "\\":
                end = text.find("\n", end + 1)
            if text[i] == "/":
                doc = []
            i = end if end >= 0 else len(text)
        elif found := re.compile(r"(public|private|protected):").match(text, i):
            public, i, doc = found[1] == "public", found.end(), []
        else:
            begin, body, head_end = i, None, None
            while i < len(text):
                j = skip(text, i)
                if j > i:
                    i = j
                elif text[i] == ";":
                    head_end = i if head_end is None else head_end
                    i += 1
                    break
                elif text[i] == "{":
                    head = text[begin:i]
                    end = closing(text, i)
                    after = text[end:end + 40].lstrip()
                    flat = bare(head)
                    kind = re.match(r"\s*(template\s*)?(inline |constexpr )*(class|struct|union|enum|namespace)\b",
                                    flat.strip())
                    function = "(" in flat and "=" not in re.sub(r"operator\S+", "", re.sub(r"\([^()]*\)", "", flat))
                    if re.search(r"(\brequires|=|&&|\|\||!|\()\s*requires\s*(\([^()]*\))?\s*$", head):
                        i = end  # a requires-expression
                    elif kind or (function and not after.startswith((",", "{"))):
                        body, head_end, i = text[i + 1:end - 1], i, end
                        break
                    else:
                        i = end
                elif text[i] in "([":
                    i = closing(text, i)
                else:
                    i += 1
            declaration = text[begin:head_end]
            while found := re.compile(r"[ \t]*\n?[ \t]*///<(.*)").match(text, i):
                doc.append(found[1].strip())
                i = found.end()
            yield " ".join(doc).strip(), re.sub(r"//.*", "", declaration), body, public
            doc = []


def namespaces(text):
    """What stands in namespace talus, details left out; inline namespaces are no border."""
    for doc, declaration, body, _ in declarations(text):
        head = declaration.strip()
        if re.match(r"(inline )?namespace", head):
            if not re.search(r"\bdetail\b", head):
                yield from namespaces(body)
        else:
            yield doc, declaration, body


def members(body, is_class):
    """(docstring, declaration) of the public members."""
    text = ("private:\n" if is_class else "") + body
    for doc, declaration, inner, public in declarations(text):
        head = " ".join(declaration.split())
        flat = re.sub(r"^template <[^{};]*?> (?=[a-z\[])", "", head)
        flat = re.sub(r"^requires [^;]*? (?=\[\[|void|[a-z_:]+ )", "", flat) if flat.startswith("requires") else flat
        if not public or not head or re.match(
                r"(static_assert|friend|using|typedef|enum|struct|class|explicit|static|~)", flat):
            continue
        yield doc, head


def tidy(head):
    """A declaration as a row of the sheet shows it."""
    head = re.sub(r"\[\[[^\]]*\]\]\s*", "", head)
    head = re.sub(r"\(\s+", "(", head)
    head = re.sub(r"^template <.*?>\s+(?=[a-z_])", "", head) if head.startswith("template") else head
    head = re.sub(r"^template <.*>\s+(?=[a-z_]+ [a-z_]+\()", "", head)
    head = re.sub(r"\brequires\b.*", "", head)
    head = re.sub(r"\b(inline|constexpr|consteval|talus::|typename )", "", head)
    return " ".join(head.replace("|", "\\|").split()).strip(" ,")


def is_function(head):
    text = re.sub(r"\{.*", "", bare(tidy(head)))
    at = text.find(" = ")
    return "(" in (text if at < 0 or "operator" in text[:at] else text[:at])


def named(head):
    """The name that is declared."""
    if found := re.search(r"\boperator\s*(\(\)|[^\s(]+)", head):
        return "operator" + found[1]
    text = bare(tidy(head))
    if is_function(head):
        return re.search(r"(\w+)\s*\(", text)[1]
    return re.split(r"[={]", text)[0].split(",")[0].split()[-1]


def first_sentence(doc):
    found = re.match(r"(.*?[^.]\.)(?= [A-Z`]|$)", doc)
    text = (found[1] if found else doc).strip()
    return text.replace("|", "\\|")


def classes(header, wanted):
    for doc, declaration, body in namespaces((include / header).read_text()):
        head = " ".join(declaration.split())
        found = re.search(r"\b(class|struct)\s+(?:\[\[[^\]]*\]\]\s*)?(\w+)(?![\w:]*\s*<)", re.sub(r"template <.*?>(?= (class|struct|requires))", "", head))
        if body is not None and found and (wanted == "*" or found[2] == wanted):
            yield found[2], doc, list(members(body, found[1] == "class"))


def fields(header, struct):
    """Names of the data members of an aggregate, in their order."""
    names = []
    for _, _, all_of in classes(header, struct):
        for _, head in all_of:
            if is_function(head) or "operator" in head:
                continue
            declarators = re.sub(r"\{[^{}]*(\{[^{}]*\}[^{}]*)*\}", "", bare(head))
            first, *rest = declarators.split(",")
            names.append(re.split(r"=", first)[0].split()[-1])
            names += [re.split(r"=", r)[0].strip() for r in rest]
    if not names:
        raise SystemExit(f"members.py: {header} has no struct {struct} with fields")
    return names


def sheet():
    lines = ["# Members", "",
             "This sheet lists the members of all types that a scenario uses, with one sentence each. The headers and the",
             "reference that `./dev docs` builds give units and errors. `./dev docs --sheet` writes this page from the headers; a",
             "test compares the two."]
    faults = []

    def row(where, name, head, doc):
        if not doc:
            faults.append(f"include/talus/{where}: '{tidy(head)}' has no docstring")
        lines.append(f"| `{tidy(head)}` | {first_sentence(doc)} |")

    for title, intro, entries in SHEET:
        lines += ["", f"## {title}", "", intro]
        for entry in entries:
            header, what = entry[0], entry[1]
            if isinstance(what, list):
                found = [(d, " ".join(h.split())) for d, h, b in namespaces((include / header).read_text())
                         if is_function(h) and not re.match(r"\s*(template <>|extern|using|static_assert)", h)]
                found = [(d, h) for d, h in found if "operator" not in h and not d.startswith("Refuses") and
                         (what == ["*"] or re.search(r"(\w+)\s*\(", bare(tidy(h)))[1] in what)]
                if not found:
                    faults.append(f"include/talus/{header}: no function {what}")
                    continue
                lines += ["", f"### Functions of {header}", "", "| | |", "|---|---|"]
                for doc, head in found:
                    row(header, "", head, doc)
                continue
            found = list(classes(header, what))
            if not found:
                faults.append(f"include/talus/{header}: no class {what}")
            for name, doc, all_of in found:
                all_of = [(d, h) for d, h in all_of
                          if not re.match(rf"(template <.*> )?(explicit )?{name}\(", tidy(h)) and
                          not d.startswith("Refuses") and named(h) not in INSIDE | INSIDE_OF.get(name, set()) and not named(h).endswith("_")]
                if not all_of:
                    continue
                if not doc:
                    faults.append(f"include/talus/{header}: '{name}' has no docstring")
                lines += ["", f"### {entry[2] or name}", "", f"{first_sentence(doc)} [{header}](../include/talus/{header})",
                          "", "| | |", "|---|---|"]
                for d, h in all_of:
                    row(header, name, h, d)
    return "\n".join(lines) + "\n", faults


def said(names):
    return ", ".join(names[:-1]) + (" and " if len(names) > 1 else "") + names[-1]


def sentences():
    lines = ["#pragma once",
             "// The fields of options, as messages list them. Written by ./dev docs --sheet from the structs.",
             '#include "talus/core/refused_fields.hpp"', "", "namespace talus::detail::fields {", "",
             "// clang-format off"]
    words = {name: f"{call} takes {'the fields' if len(f) > 1 else 'the field'} {said(f)}, "
                   f"{'in this order' if len(f) > 1 else 'with a value of its type'}"
             for name, header, struct, call in FIELDS for f in [fields(header, struct)]}
    words["decomposition"] = ("world.decompose({...}) takes the fields of its decomposition, which "
                              "docs/policies/decomposition.md lists, in their order")
    for name, text in words.items():
        lines += [f'inline constexpr sentence {name} = "{text}";',
                  f"template <sentence S> struct no_{name} {{",
                  f'  static_assert(unrefused<S>, "{text}");', "};",
                  f"struct {name}_fields {{",
                  f"  static constexpr auto says = {name};",
                  f"  template <sentence S> using refused = no_{name}<S>;", "};"]
    lines += ["// clang-format on", "",
              "/// The fields of a decomposition: its own, or a sentence that refers to them.",
              "template <class Decomposition>", "struct of_decomposition {", "  using type = decomposition_fields;",
              "};", "template <class Decomposition>", "requires requires { typename Decomposition::talus_fields; }",
              "struct of_decomposition<Decomposition> {", "  using type = typename Decomposition::talus_fields;",
              "};", "", "}  // namespace talus::detail::fields"]
    return "\n".join(lines) + "\n"


def misspelt():
    """Each policy with two neighbouring letters swapped, or one left out, unless talus uses that word."""
    used = {word for file in include.rglob("*.hpp") if file.name != "misspelt.hpp" for word in re.findall(r"\w+", file.read_text())}
    lines = ["#pragma once",
             "// Policies with two letters swapped or one left out: g++ would suggest a function of C, such as",
             "// islower for slover. Written by ./dev docs --sheet.",
             '#include "talus/core/not_there.hpp"', "", "namespace talus {", "", "// clang-format off",
             "#define TALUS_MISSPELT(right, wrong) \\",
             '  template <class...> struct TALUS_REFUSED_NAME("did you mean " #right "<...>?") wrong;']
    for right in POLICIES:
        swapped = [right[:k] + right[k + 1] + right[k] + right[k + 2:] for k in range(len(right) - 1)]
        shorter = [right[:k] + right[k + 1:] for k in range(len(right))]
        wrongs = [w for w in dict.fromkeys(swapped + shorter) if w not in used and not w.startswith("_") and "__" not in w]
        lines += [f"TALUS_MISSPELT({right}, {wrong})" for wrong in wrongs]
    lines += ["#undef TALUS_MISSPELT", "// clang-format on", "", "}  // namespace talus"]
    return "\n".join(lines) + "\n"


def main():
    page, faults = sheet()
    outputs = {root / "docs" / "members.md": page, include / "core" / "field_names.hpp": sentences(),
               include / "core" / "misspelt.hpp": misspelt()}
    for header, struct in NAMED:
        listed, article = fields(header, struct), "an" if struct[0] in "aeiou" else "a"
        prefix = struct + "_have_" if struct == "joint_limits" else f"{article}_{struct}_has_"
        outputs[include / header] = re.sub(rf"\b{prefix}\w+", prefix + said(listed).replace(", ", "_").replace(" ", "_"),
                                           outputs.get(include / header) or (include / header).read_text())
    for file, text in outputs.items():
        if "--check" in sys.argv:
            if not file.is_file() or file.read_text() != text:
                faults.append(f"{file.relative_to(root)} is out of date: run ./dev docs --sheet")
        elif not file.is_file() or file.read_text() != text:
            file.write_text(text)
    print("\n".join(faults))
    print(f"{page.count(chr(10) + '| `')} members, {len(faults)} faults")
    sys.exit(1 if faults else 0)


main()
