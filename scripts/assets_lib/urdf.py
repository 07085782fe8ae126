"""Records of objects, and functions that write URDF and OBJ files.

A `Model` has links with coloured visual parts and convex collision parts, and joints. Inertias are computed from the parts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from assets_lib.files import mtl_text, number, numbers, obj_text, significant, write_text
from assets_lib.mesh import FloatArray, Mesh, box, corner_normals, cylinder, icosphere, mass_properties, rotation
from assets_lib.occlusion import shades_of
from assets_lib.refine import CELLS, added, cut, shaded_quads
from assets_lib.textures import PATTERN_SIZES, PATTERNS

Vec3 = tuple[float, float, float]
ZERO: Vec3 = (0.0, 0.0, 0.0)
TRIANGLES, LARGE, FURNITURE = 1100, 0.3, (200, 1400)
"""Most triangles of an object whose flat faces are cut into cells. Where a mesh is as long as `LARGE` [m], cells may add as many
as the first of `FURNITURE` up to the second."""
SMOOTH = 0.7
"""Default crease angle of visual meshes [rad]."""


@dataclass(frozen=True)
class Shape:
    """A geometry at a place: a primitive, or a mesh that becomes `<name>.obj`."""

    kind: Literal["box", "cylinder", "sphere", "mesh"]
    size: tuple[float, ...] = ()
    """box: x, y, z; cylinder: radius, length; sphere: radius."""
    xyz: Vec3 = ZERO
    rpy: Vec3 = ZERO
    name: str = ""
    """File name of a mesh, without ending."""
    data: Mesh | None = None

    def mesh(self) -> Mesh:
        """Return the shape as a closed mesh in the link frame."""
        if self.kind == "box":
            base = box(self.size)
        elif self.kind == "cylinder":
            base = cylinder(self.size[0], self.size[1], 48)
        elif self.kind == "sphere":
            base = icosphere(self.size[0], 3)
        else:
            assert self.data is not None
            base = self.data
        return base.moved(self.xyz, self.rpy)


def box_shape(size: Vec3, xyz: Vec3 = ZERO, rpy: Vec3 = ZERO) -> Shape:
    """Return a box primitive."""
    return Shape("box", size, xyz, rpy)


def cylinder_shape(radius: float, length: float, xyz: Vec3 = ZERO, rpy: Vec3 = ZERO) -> Shape:
    """Return a cylinder primitive along its z."""
    return Shape("cylinder", (radius, length), xyz, rpy)


def sphere_shape(radius: float, xyz: Vec3 = ZERO) -> Shape:
    """Return a sphere primitive."""
    return Shape("sphere", (radius,), xyz)


def mesh_shape(name: str, data: Mesh, xyz: Vec3 = ZERO, rpy: Vec3 = ZERO) -> Shape:
    """Return a mesh that is written to `<name>.obj`."""
    return Shape("mesh", (), xyz, rpy, name, data)


@dataclass(frozen=True)
class Paint:
    """A colour with a finish."""

    color: Vec3
    gloss: Vec3 = ZERO
    """Share of red, green, blue that it throws back like a mirror."""
    opacity: float = 1.0
    """Opacity; below 1 the background shows through."""
    emission: Vec3 | None = None
    """Colour in which it shines."""
    reach: float = 0.0
    """How far its light reaches when it shines [m]."""
    pattern: str = ""
    """Image of `assets/patterns` that brightens and darkens its colour, without ending."""


def patterned(paint: Vec3 | Paint, pattern: str) -> Paint:
    """Return a colour or a finish with a pattern."""
    return replace(paint if isinstance(paint, Paint) else Paint(paint), pattern=pattern)


def metal(color: Vec3) -> Paint:
    """Return the look of metal: mirrors much, in its colour."""
    red, green, blue = color
    return Paint(color, (0.7 * red, 0.7 * green, 0.7 * blue))


def glass(color: Vec3) -> Paint:
    """Return the look of glass and glaze: mirrors some, in white."""
    return Paint(color, (0.15, 0.15, 0.15))


def pane(color: Vec3, opacity: float = 0.35) -> Paint:
    """Return the look of clear glass: mirrors some, in white, and lets the light through."""
    return Paint(color, (0.15, 0.15, 0.15), opacity)


def shining(color: Vec3, *, emission: Vec3 | None = None, reach: float = 0.0) -> Paint:
    """Return the look of a lamp or a display that shines in its colour, or in another that it gets."""
    return Paint(color, emission=emission or color, reach=reach)


def plastic(color: Vec3) -> Paint:
    """Return the look of polished plastic and varnish: mirrors little, in white."""
    return Paint(color, (0.05, 0.05, 0.05))


def glossy(paint: Vec3 | Paint, share: float = 0.1) -> Paint:
    """Return a colour or a finish that mirrors a share of the light, in white."""
    return replace(paint if isinstance(paint, Paint) else Paint(paint), gloss=(share, share, share))


@dataclass(frozen=True)
class Visual:
    """A coloured part that is seen."""

    shape: Shape
    paint: Vec3 | Paint
    """Its colour, dull; or a finish."""
    texture: str | None = None
    """Name of a PNG beside the URDF, without ending."""
    crease: float = SMOOTH
    grade: Callable[[FloatArray], FloatArray] | None = None
    """Returns by which share places (n, 3) of the shape are darker than its colour, as shades in 0..1 (n,)."""

    @property
    def color(self) -> Vec3:
        """Red, green, blue."""
        return self.paint.color if isinstance(self.paint, Paint) else self.paint

    @property
    def finish(self) -> Paint:
        """Its colour and what else there is to it."""
        return self.paint if isinstance(self.paint, Paint) else Paint(self.paint)


@dataclass(frozen=True)
class Link:
    """A rigid part."""

    name: str
    mass: float
    visuals: tuple[Visual, ...]
    collisions: tuple[Shape, ...] = ()
    friction: float = 0.8
    rolling: float = 0.0
    """Rolling friction [m]."""
    spins: bool = False
    """Whether nothing but sliding friction stops its spinning about a point of contact; else spinning friction is as rolling."""
    anchored: bool = False
    """Whether it holds on to the points where it touches, so that friction alone does not creep."""
    center: Vec3 | None = None
    """Centre of mass [m], where it is not that of the parts."""
    weighs: tuple[Shape, ...] = ()
    """Parts over which the mass of a link that nothing collides with is spread; those that are seen, if there are none."""


@dataclass(frozen=True)
class Joint:
    """How a link moves on its parent."""

    name: str
    kind: Literal["revolute", "prismatic", "fixed"]
    parent: str
    child: str
    xyz: Vec3
    axis: Vec3 = (0.0, 0.0, 1.0)
    lower: float = 0.0
    upper: float = 0.0
    damping: float = 0.0
    rpy: Vec3 = ZERO


@dataclass(frozen=True)
class Model:
    """One object."""

    name: str
    folder: str
    """Folder below `assets/`."""
    origin: str
    """Where the origin is, in words, for the catalogue."""
    links: tuple[Link, ...]
    joints: tuple[Joint, ...] = ()
    notes: tuple[str, ...] = field(default=())
    """Places that a scene author needs: handles, surfaces, free heights."""


def inertia_of(link: Link) -> tuple[FloatArray, FloatArray]:
    """Return centre [m] and inertia about it [kg m^2] of a link, its mass spread evenly over its parts.

    A link without parts is a ball of 1 cm radius.
    """
    shapes = link.collisions or link.weighs or tuple(v.shape for v in link.visuals) or (sphere_shape(0.01),)
    parts = [mass_properties(s.mesh()) for s in shapes]
    volume = sum(p[0] for p in parts)
    center = sum(p[0] * p[1] for p in parts) / volume
    inertia = np.zeros((3, 3))
    for v, c, moments in parts:
        d = c - center
        inertia += moments + v * (d @ d * np.eye(3) - np.outer(d, d))
    inertia *= link.mass / volume
    return (center if link.center is None else np.array(link.center)), inertia


def _geometry(shape: Shape) -> str:
    if shape.kind == "box":
        inner = f'<box size="{numbers(shape.size)}"/>'
    elif shape.kind == "cylinder":
        inner = f'<cylinder radius="{number(shape.size[0])}" length="{number(shape.size[1])}"/>'
    elif shape.kind == "sphere":
        inner = f'<sphere radius="{number(shape.size[0])}"/>'
    else:
        inner = f'<mesh filename="{shape.name}.obj"/>'
    return f"<geometry>{inner}</geometry>"


def _origin(xyz: Sequence[float], rpy: Sequence[float]) -> str:
    return f'<origin xyz="{numbers(xyz)}" rpy="{numbers(rpy, 8)}"/>'


def _link_lines(link: Link) -> list[str]:
    center, inertia = inertia_of(link)
    names = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
    clean = np.where(np.abs(inertia) < 1e-6 * np.max(np.abs(inertia)), 0.0, inertia)
    moments = " ".join(f'{n}="{significant(clean[i, j])}"' for n, i, j in names)
    lines = [f'  <link name="{link.name}">']
    rolling = f'<rolling_friction value="{number(link.rolling)}"/>'
    if not link.spins:
        rolling += f'<spinning_friction value="{number(link.rolling)}"/>'
    more = (rolling if link.rolling else "") + ("<friction_anchor/>" if link.anchored else "")
    lines.append(f'    <contact><lateral_friction value="{number(link.friction)}"/>{more}</contact>')
    lines += ["    <inertial>", f"      {_origin(center, ZERO)}"]
    lines += [f'      <mass value="{significant(link.mass)}"/>', f"      <inertia {moments}/>", "    </inertial>"]
    for i, visual in enumerate(link.visuals):
        finish = visual.finish
        rgba = numbers((*finish.color, finish.opacity), 4)
        lines += ["    <visual>", f"      {_origin(visual.shape.xyz, visual.shape.rpy)}", f"      {_geometry(visual.shape)}"]
        more = f'<specular rgb="{numbers(finish.gloss, 4)}"/>' if any(finish.gloss) else ""
        if finish.emission is not None:
            reach = f' reach="{number(finish.reach)}"' if finish.reach else ""
            more += f'<emission rgb="{numbers(finish.emission, 4)}"{reach}/>'
        if finish.pattern:
            size = number(PATTERN_SIZES[finish.pattern])
            more += f'<pattern filename="../../{PATTERNS}/{finish.pattern}.png" size="{size}"/>'
        lines += [f'      <material name="{link.name}_{i}"><color rgba="{rgba}"/>{more}</material>', "    </visual>"]
    for shape in link.collisions:
        lines += ["    <collision>", f"      {_origin(shape.xyz, shape.rpy)}", f"      {_geometry(shape)}", "    </collision>"]
    return [*lines, "  </link>"]


def _joint_lines(joint: Joint) -> list[str]:
    lines = [f'  <joint name="{joint.name}" type="{joint.kind}">', f"    {_origin(joint.xyz, joint.rpy)}"]
    lines += [f'    <parent link="{joint.parent}"/>', f'    <child link="{joint.child}"/>']
    if joint.kind != "fixed":
        limits = f'lower="{number(joint.lower)}" upper="{number(joint.upper)}" effort="100" velocity="10"'
        lines += [f'    <axis xyz="{numbers(joint.axis)}"/>', f"    <limit {limits}/>"]
        lines.append(f'    <dynamics damping="{number(joint.damping)}" friction="0"/>')
    return [*lines, "  </joint>"]


def urdf_text(model: Model) -> str:
    """Return the URDF of a model."""
    lines = ['<?xml version="1.0"?>', "<!-- made by scripts/build_assets.py -->", f'<robot name="{model.name}">']
    for link in model.links:
        lines += _link_lines(link)
    for joint in model.joints:
        lines += _joint_lines(joint)
    return "\n".join([*lines, "</robot>"]) + "\n"


@dataclass(frozen=True)
class _Skin:
    """The mesh of a visual part as it is written, in its own frame."""

    mesh: Mesh
    normals: FloatArray
    """Of the corners of its faces, (m, 3, 3)."""
    shades: FloatArray | None = None
    """How much light reaches them, (m, 3)."""


def _is_shaded(link: Link) -> bool:
    """Whether light is baked into the visuals of a link; not where they have textures, as those of the room."""
    return bool(link.visuals) and all(visual.texture is None for visual in link.visuals)


def _skins(model: Model) -> dict[str, list[_Skin]]:
    """Return the meshes of the visuals of each link, by its name: flat faces on which the light changes cut into cells.

    Objects that nothing collides with keep their meshes, because sensors use those.
    """
    skins, quads = {}, {}
    for link in model.links:
        bare = [visual.shape.data or replace(visual.shape, xyz=ZERO, rpy=ZERO).mesh() for visual in link.visuals]
        skins[link.name] = [_Skin(own, corner_normals(own, v.crease)) for own, v in zip(bare, link.visuals, strict=True)]
        if _is_shaded(link) and any(each.collisions for each in model.links):
            found = shaded_quads([visual.shape.mesh() for visual in link.visuals])
            quads[link.name] = [own if v.shape.data else [] for own, v in zip(found, link.visuals, strict=True)]
    count = sum(
        len(s.mesh.faces) for link in model.links for s, v in zip(skins[link.name], link.visuals, strict=True) if v.shape.data
    )

    def more(cell: float) -> int:
        return sum(added(s.mesh, q, cell) for name, own in quads.items() for s, q in zip(skins[name], own, strict=True))

    sizes = [np.ptp(s.mesh.vertices, axis=0).max() for own in skins.values() for s in own]
    most = max(TRIANGLES, min(count + FURNITURE[0], FURNITURE[1])) if max(sizes, default=0.0) >= LARGE else TRIANGLES
    cell = next((cell for cell in CELLS if count + more(cell) <= most), None)
    for link in model.links:
        own = skins[link.name]
        if cell is not None and link.name in quads:
            own = [_Skin(*cut(s.mesh, s.normals, q, cell)) for s, q in zip(own, quads[link.name], strict=True)]
        skins[link.name] = _with_shades(link, own) if _is_shaded(link) else own
    return skins


def _with_shades(link: Link, skins: Sequence[_Skin]) -> list[_Skin]:
    placed = [skin.mesh.moved(v.shape.xyz, v.shape.rpy) for skin, v in zip(skins, link.visuals, strict=True)]
    normals = [skin.normals @ rotation(v.shape.rpy).T for skin, v in zip(skins, link.visuals, strict=True)]
    solid = [v.shape.mesh() for v in link.visuals if v.finish.opacity == 1.0]
    shades = shades_of(placed, normals, solid)
    for k, visual in enumerate(link.visuals):
        if visual.grade is not None:
            shades[k] = shades[k] * visual.grade(skins[k].mesh.vertices)[skins[k].mesh.faces]
    return [replace(skin, shades=own) for skin, own in zip(skins, shades, strict=True)]


def write_model(model: Model, assets: Path) -> None:
    """Write the URDF and the meshes of a model below `assets`."""
    folder = assets / model.folder
    write_text(folder / f"{model.name}.urdf", urdf_text(model))
    skins = _skins(model)
    for link in model.links:
        for visual, skin in zip(link.visuals, skins[link.name], strict=True):
            if visual.shape.data is not None:
                text = obj_text(skin.mesh, crease=visual.crease, texture=visual.texture, normals=skin.normals, shades=skin.shades)
                write_text(folder / f"{visual.shape.name}.obj", text)
            if visual.texture is not None:
                write_text(folder / f"{visual.texture}.mtl", mtl_text(visual.texture))
        for shape in link.collisions:
            if shape.data is not None:
                write_text(folder / f"{shape.name}.obj", obj_text(shape.data, crease=None))
