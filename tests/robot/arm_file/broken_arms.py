"""Small MJCF and URDF texts, and broken ones with what is said of each."""

INERTIAL = (
    "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"  # of a cube
)
LIMIT = "<limit lower='-1' upper='1' effort='1' velocity='1'/>"


def link(name, content=INERTIAL):
    return f"<link name='{name}'>{content}</link>"


def joint(name, parent, child, kind="revolute", more=LIMIT):
    ends = f"<parent link='{parent}'/><child link='{child}'/>"
    return f"<joint name='{name}' type='{kind}'>{ends}<axis xyz='0 0 1'/>{more}</joint>"


def urdf(*parts):
    return f"<robot name='r'>{''.join(parts)}</robot>"


def mjcf(bodies, more=""):
    return f"<mujoco>{more}<worldbody>{bodies}</worldbody></mujoco>"


def body(name, content="", joint_text="<joint name='j_{name}'/>", mass="<geom name='g_{name}' size='0.1'/>"):
    return f"<body name='{name}'>{joint_text.format(name=name)}{mass.format(name=name)}{content}</body>"


def shape(filename):
    return f"{INERTIAL}<visual><geometry><mesh filename='{filename}'/></geometry></visual>"


ARM = link("a") + link("b") + joint("j", "a", "b")
CHAIN = body("a", body("b"))
TWO_JOINTS = "<joint name='j_{name}'/><joint name='k_{name}' axis='0 1 0'/>"
MESH = "<asset><mesh name='hull' file='hull.stl'/></asset>"
GEOM = "<geom type='mesh' mesh='hull'/>"
WEIGHT = "<inertial mass='1' pos='0 0 0' diaginertia='1 1 1'/>"

BROKEN = {
    # no arm file at all
    "empty": ("", "the file is empty"),
    "blank": ("  \n", "it is empty"),
    "text": ("six axes, 60 kg", "it is no XML"),
    "page": ("<!DOCTYPE html><html><body/></html>", "it starts with <html>"),
    "usd": ("#usda 1.0\ndef Xform 'robot' {}", "it is no XML"),
    "cut MJCF": ("<mujoco><worldbody><body>", "MuJoCo refuses it: XML parse error"),
    "cut URDF": ("<robot name='r'><link name='a'>", "not valid XML: no element found"),
    "xacro": ("<robot xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:arm/></robot>", "Expand it first: xacro"),
    "encoding": ("<?xml version='1.0' encoding='klingon'?><robot name='r'/>", "not valid XML: unknown encoding"),
    "MJCF attribute": (mjcf(body("a", joint_text="<joint size='1'/>")), "unrecognized attribute: 'size'"),
    "MJCF element": (mjcf("<link/>"), "unrecognized element"),
    "include": ("<mujoco><include file='other.xml'/></mujoco>", "Error opening file 'other.xml'"),
    # no links and joints that fit together
    "no links": (urdf(), "It has no links"),
    "no joints URDF": (urdf(link("a")), "It has no joints, so nothing can move"),
    "no joints MJCF": (mjcf(body("a", joint_text="")), "It has no joints, so nothing can move"),
    "two roots": (urdf(ARM, link("c")), "It has 2 links without a parent, ['a', 'c']"),
    "two parents": (
        urdf(ARM, link("c"), joint("k", "b", "c"), joint("l", "a", "c")),
        "Link 'c' has two parents, 'b' and 'a': a closed loop",
    ),
    "all in a loop": (urdf(ARM, joint("k", "b", "a")), "It has 0 links without a parent, []"),
    "some in a loop": (
        urdf(ARM, link("c"), link("d"), joint("k", "c", "d"), joint("l", "d", "c")),
        "Links ['d', 'c', 'd'] hang on each other in a loop",
    ),
    "link twice": (urdf(ARM, link("a")), "Every link needs a name of its own, but there is 'a'"),
    "joint twice": (urdf(ARM, link("c"), joint("j", "b", "c")), "Every joint needs a name of its own"),
    "joint without name": (urdf(ARM).replace("name='j'", ""), "Every joint needs a name of its own"),
    "no such child": (urdf(link("a"), joint("j", "a", "b")), "Joint 'j': its child is 'b', which is no link"),
    "no parent": (urdf(ARM).replace("<parent link='a'/>", ""), "Joint 'j': its parent is None"),
    "unknown type": (
        urdf(link("a"), link("b"), joint("j", "a", "b", "helical")),
        "Unknown type of joint 'j' 'helical'",
    ),
    "planar": (urdf(link("a"), link("b"), joint("j", "a", "b", "planar")), "Joint 'j' is planar"),
    "floating": (urdf(link("a"), link("b"), joint("j", "a", "b", "floating")), "Joint 'j' is floating"),
    "ball": (mjcf(body("a", joint_text="<joint name='j' type='ball'/>")), "Joint 'j' is a ball joint"),
    "free": (mjcf(body("a", body("b"), "<freejoint name='j'/>")), "Joint 'j' is a free joint"),
    "branches MJCF": (mjcf(body("a", body("b") + body("c"))), "It branches after 'j_a': ['j_b'] or ['j_c']"),
    "branches URDF": (urdf(ARM, link("c"), joint("k", "a", "c")), "It has several chains: ['j'] or ['k']"),
    "two arms": (mjcf(CHAIN + body("c")), "It has several chains: ['j_a', 'j_b'] or ['j_c']"),
    "mimic": (
        urdf(ARM, link("c"), joint("k", "b", "c", more=f"{LIMIT}<mimic joint='j' multiplier='2'/>")),
        "(equality, mimic) ties joint 'k' to 'j'",
    ),
    "connect": (
        mjcf(body("a", body("b")), "<equality><connect name='rod' body1='b' anchor='0 0 0'/></equality>"),
        "The constraint 'rod' between 'b' and 'world' closes a loop",
    ),
    "weld": (
        mjcf(body("a", body("b")), "<equality><weld body1='b' body2='a'/></equality>"),
        "The constraint 'number 1' between 'b' and 'a' closes a loop",
    ),
    "weld of sites": (
        mjcf(
            "<site name='here'/><site name='also'/><site name='too'/>" + body("a", body("b") + "<site name='there'/>"),
            "<equality><weld name='w' site1='there' site2='here'/></equality>",
        ),
        "The constraint 'w' between 'a' and 'world' closes a loop",
    ),
    "tied joint": (
        mjcf(CHAIN, "<equality><joint name='belt' joint1='j_a' joint2='j_b'/></equality>"),
        "The constraint 'belt' (equality, mimic) ties joint 'j_a' to 'j_b'",
    ),
    "tied tendon": (
        mjcf(
            CHAIN,
            "<tendon><fixed name='t'><joint joint='j_a' coef='1'/><joint joint='j_b' coef='1'/></fixed></tendon>"
            "<equality><tendon tendon1='t'/></equality>",
        ),
        "ties joint 'j_a' to 'j_b'",
    ),
    "bad name": (mjcf(body("a", joint_text="<joint name='axis 1'/>")), "Joint 'axis 1' cannot name columns"),
    # limits
    "limits URDF": (urdf(ARM).replace("lower='-1'", "lower='2'"), "Joint 'j': limit lower = 2.0 is above upper = 1.0"),
    "limit text": (urdf(ARM).replace("lower='-1'", "lower='low'"), "joint 'j' limit: lower = 'low' must be a number"),
    "limit nan": (urdf(ARM).replace("velocity='1'", "velocity='nan'"), "velocity = 'nan' must be a number"),
    "limits MJCF": (mjcf(body("a", joint_text="<joint name='j' range='30 -30'/>")), "Joint 'j': range [30.0, -30.0]"),
    "autolimits": (
        mjcf(body("a", joint_text="<joint range='-30 30'/>"), "<compiler autolimits='false'/>"),
        "joint has `range` but not `limited`",
    ),
    # masses
    "massless URDF": (urdf(link("a"), link("b", ""), joint("j", "a", "b")), "Element name 'b'"),
    "shapes weigh nothing": (
        urdf(link("a"), link("b", "<visual><geometry><sphere radius='1'/></geometry></visual>"), joint("j", "a", "b")),
        "Element name 'b'",
    ),
    "massless MJCF": (mjcf(body("a", mass="")), "Element name 'a'"),
    "massless way out": (mjcf(body("a", mass="")), "A link that moves must weigh something"),
    "two joints in a body": (
        mjcf(body("a", joint_text=TWO_JOINTS)),
        "Joints 'j_a' and 'k_a' are both in body 'a', so the link between them weighs nothing",
    ),
    "no inertia": (
        urdf(link("a"), link("b", "<inertial><mass value='1'/></inertial>"), joint("j", "a", "b")),
        "inertia",
    ),
    "unphysical": (urdf(ARM).replace("ixx='1'", "ixx='5'"), "No body has such an inertia"),
    "negative inertia": (urdf(ARM).replace("ixx='1'", "ixx='-1'"), "inertia"),
    "mass is text": (urdf(ARM).replace("mass value='1'", "mass value='heavy'"), "bad format in attribute 'value'"),
    "mass is nan": (urdf(ARM).replace("mass value='1'", "mass value='nan'"), "must be larger than mjMINVAL"),
    "place is nan": (
        mjcf("<body pos='nan 0 0'><joint/><geom size='1'/></body>"),
        "A position, angle, axis or reference in it is not a finite number",
    ),
    "range is infinite": (mjcf(body("a", joint_text="<joint range='-inf 1'/>")), "kinematics.range must be finite"),
    "mass is infinite": (mjcf(body("a", mass="<geom size='1' mass='inf'/>")), "in"),
    "axis is zero": (urdf(ARM).replace("0 0 1", "0 0 0"), "axis too small"),
    # looks
    "mesh URDF": (
        urdf(link("a", shape("meshes/hull.stl")), link("b"), joint("j", "a", "b")),
        "The mesh 'meshes/hull.stl' of link 'a' visual is missing; looked for {folder}/meshes/hull.stl. Put it there, "
        'or leave the looks out: --no-looks of ffgym robot new, looks = "none" in [robot]',
    ),
    "mesh in package": (
        urdf(link("a", shape("package://arm/hull.stl")), link("b"), joint("j", "a", "b")),
        "The mesh 'package://arm/hull.stl' of link 'a' visual is missing; looked for {folder}/arm/hull.stl, ",
    ),
    "mesh MJCF": (
        mjcf(body("a", mass=WEIGHT + GEOM), MESH),
        "The mesh 'hull' is missing; looked for {folder}/hull.stl. Put it there, or leave the looks out",
    ),
    "mesh that weighs": (
        mjcf(body("a", mass=GEOM), MESH),
        "The mesh 'hull' is missing; looked for {folder}/hull.stl. Put it there, or give body 'a' an <inertial>: its "
        "mass comes from this mesh",
    ),
    "no geometry": (urdf(link("a", "<visual/>"), link("b"), joint("j", "a", "b")), "link 'a' visual: has no geometry"),
    "odd geometry": (
        urdf(link("a", "<visual><geometry><cone/></geometry></visual>"), link("b"), joint("j", "a", "b")),
        "link 'a' visual: geometry is 'cone', must be a mesh, box, cylinder, capsule, sphere",
    ),
    "no size": (
        urdf(link("a", "<visual><geometry><box/></geometry></visual>"), link("b"), joint("j", "a", "b")),
        "link 'a' visual: the box lacks a size",
    ),
    "half a size": (
        urdf(
            link("a", "<visual><geometry><cylinder radius='1'/></geometry></visual>"), link("b"), joint("j", "a", "b")
        ),
        "link 'a' visual: the cylinder lacks a size",
    ),
    "transmission": (
        urdf(ARM, "<transmission><joint name='j'/><mechanicalReduction>high</mechanicalReduction></transmission>"),
        "mechanicalReduction of joint 'j' is 'high', must be a number",
    ),
}
