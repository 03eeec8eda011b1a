//! Trees, their light and the ground, ready to be looked at.

use std::sync::Arc;

use deeptree_graph::NodeId;
use deeptree_mesh::{Dressed, Image, Internode, Material};
use glam::{Vec2, Vec3, Vec4};

use crate::bsdf::Bsdf;
use crate::error::RenderError;
use crate::geometry::{Hit, What, world_from_blade};
use crate::ggx::Ggx;
use crate::ground::Ground;
use crate::grove::{Grove, Met};
use crate::light::Light;
use crate::ray::Ray;
use crate::texture::Texture;

/// A tree and the place that its foot stands at.
#[derive(Clone, Copy, Debug)]
pub struct Standing<'a> {
    /// The tree in its own space.
    pub tree: &'a Dressed,
    /// Where the origin of its space is, in metres.
    pub at: Vec3,
}

/// Trees, their light and the ground, ready to be looked at.
pub struct Scene<'a> {
    grove: Grove,
    trees: Vec<Tree<'a>>,
    pub(crate) light: Light,
    pub(crate) ground: Ground,
}

/// A tree with its materials.
struct Tree<'a> {
    standing: Standing<'a>,
    bark: Look<'a>,
    leaves: Vec<Look<'a>>,
}

/// A material with its pictures checked.
struct Look<'a> {
    material: &'a Material,
    color: Option<Texture<'a>>,
    normal: Option<Texture<'a>>,
    roughness: Option<Texture<'a>>,
    /// Where its surface has holes, they begin below this alpha.
    cutoff: Option<f32>,
}

/// A place that a ray met.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// On its triangle.
    pub(crate) point: Vec3,
    /// From there to the round surface that its normals speak of: of wood seen from outside.
    lift: Vec3,
    /// Of the triangle, on the side the ray came from; of wood seen from outside, of the round
    /// surface.
    pub(crate) normal: Vec3,
    /// Local frame of the shading: the last is its normal.
    frame: [Vec3; 3],
    pub(crate) bsdf: Bsdf,
    pub(crate) label: Label,
    /// Number of the tree; 0 where there is none.
    pub(crate) tree: usize,
}

/// What is seen at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Label {
    Ground,
    Wood(NodeId),
    Leaf(NodeId),
}

impl<'a> Scene<'a> {
    /// Prepares a tree for rays.
    ///
    /// # Errors
    ///
    /// When the tree has no surface, or its meshes or materials contradict themselves.
    pub fn new(tree: &'a Dressed, light: Light, ground: Ground) -> Result<Self, RenderError> {
        Self::of(&[Standing { tree, at: Vec3::ZERO }], light, ground)
    }

    /// Prepares trees that stand together for rays; they may be the same tree at several places.
    ///
    /// # Errors
    ///
    /// As [`Scene::new`], of any of them; and when there is none, or a place is not finite.
    pub fn of(trees: &[Standing<'a>], light: Light, ground: Ground) -> Result<Self, RenderError> {
        let grove = Grove::new(trees)?;
        let trees = trees.iter().map(|&standing| Tree::new(standing)).collect::<Result<_, _>>()?;
        Ok(Self { grove, trees, light, ground })
    }

    /// Distance to the farthest corner of the box around all trees.
    pub(crate) fn farthest(&self, from: Vec3) -> f32 {
        let (low, high) = self.grove.bounds();
        (from - low).abs().max((from - high).abs()).length()
    }

    /// What is known of an internode of a tree.
    pub(crate) fn internode(&self, tree: usize, node: NodeId) -> Option<&Internode> {
        self.trees.get(tree)?.standing.tree.wood.internodes.get(node as usize)
    }

    /// Points that what is seen of the trees lies between, as [`points`] says.
    pub fn points(&self) -> impl Iterator<Item = Vec3> + Clone + '_ {
        self.trees.iter().flat_map(|Tree { standing: Standing { tree, at }, .. }| {
            points(tree).map(move |p| p + *at)
        })
    }

    /// What the ray meets first.
    pub(crate) fn meet(&self, ray: &Ray) -> Option<Surface> {
        let ground = self.ground.meet(ray);
        let ahead = Ray { most: ground.unwrap_or(ray.most), ..*ray };
        if let Some(met) = self.grove.first(&ahead, |met| self.is_there(met)) {
            return Some(self.surface(&met, -ray.direction));
        }
        ground.map(|distance| {
            let mut point = ray.origin + ray.direction * distance;
            point.y = 0.0;
            Surface::new(point, Vec3::Y, Vec3::Y, self.ground.bsdf(point), Label::Ground, 0)
        })
    }

    /// Does the ray get away?
    pub(crate) fn is_free(&self, ray: &Ray) -> bool {
        self.ground.meet(ray).is_none() && !self.is_shaded(ray)
    }

    /// Is anything of the trees in the way?
    pub(crate) fn is_shaded(&self, ray: &Ray) -> bool {
        self.grove.any(ray, |met| self.is_there(met))
    }

    /// Is there a surface, and no hole?
    fn is_there(&self, &Met { tree, ref hit }: &Met) -> bool {
        let tree = &self.trees[tree];
        let look = tree.look(hit.what);
        let Some(cutoff) = look.cutoff else { return true };
        let alpha = look.material.color[3]
            * look.color.map_or(1.0, |texture| texture.alpha(tree.corners(hit).uv));
        alpha >= cutoff
    }

    fn surface(&self, &Met { tree: number, ref hit }: &Met, towards: Vec3) -> Surface {
        let tree = &self.trees[number];
        let look = tree.look(hit.what);
        let Corners { mut point, lift: round, edges: [b, c], mut normal, uv, uv_edges, label } =
            tree.corners(hit);
        let mut lift = Vec3::ZERO;
        let mut flat = b.cross(c).try_normalize().unwrap_or(normal);
        let mut along_u = uv_edges[1].y * b - uv_edges[0].y * c;
        let mut along_v = uv_edges[0].x * c - uv_edges[1].x * b;
        let turn = uv_edges[0].perp_dot(uv_edges[1]);
        if turn < 0.0 {
            (along_u, along_v) = (-along_u, -along_v);
        }
        if let What::Leaf { kind, number, .. } = hit.what {
            let leaf = &tree.standing.tree.foliage[kind as usize].leaves[number as usize];
            point = world_from_blade(leaf, point);
            for direction in [&mut normal, &mut flat, &mut along_u, &mut along_v] {
                *direction = leaf.rotation * *direction;
            }
        }
        let normal = normal.try_normalize().unwrap_or(flat);
        let mut shading = look.bump(uv, normal, along_u, along_v);
        if flat.dot(towards) < 0.0 {
            flat = -flat;
        } else if let What::Wood { .. } = hit.what {
            // Seen from outside, wood is as round as its normals say.
            lift = round;
            flat = normal;
        }
        if shading.dot(flat) < 0.0 {
            shading = -shading;
        }
        // Bent so that the side that is looked at is not turned away.
        let facing = shading.dot(towards);
        const LEAST: f32 = 0.02;
        if facing < LEAST {
            shading = (shading + towards * (LEAST - facing)).try_normalize().unwrap_or(flat);
        }
        let bsdf = look.bsdf(uv);
        let at = point + tree.standing.at;
        Surface { lift, ..Surface::new(at, flat, shading, bsdf, label, number) }
    }
}

impl<'a> Tree<'a> {
    fn new(standing: Standing<'a>) -> Result<Self, RenderError> {
        let looks = standing.tree.foliage.iter().map(|f| Look::new(&f.material));
        Ok(Self {
            bark: Look::new(&standing.tree.bark)?,
            leaves: looks.collect::<Result<_, _>>()?,
            standing,
        })
    }

    fn look(&self, what: What) -> &Look<'a> {
        match what {
            What::Wood { .. } => &self.bark,
            What::Leaf { kind, .. } => &self.leaves[kind as usize],
        }
    }

    /// What lies at a hit, in the space of its triangles.
    fn corners(&self, hit: &Hit) -> Corners {
        let [v, w] = hit.meeting.weights;
        let weights = [1.0 - v - w, v, w];
        let (positions, normals, uvs, [i, j, k], label) = match hit.what {
            What::Wood { triangle } => {
                let wood = &self.standing.tree.wood;
                let t = wood.indices.as_chunks::<3>().0[triangle as usize].map(|i| i as usize);
                let node = wood.nodes[t[0]];
                (&wood.positions, &wood.normals, &wood.uvs, t, Label::Wood(node))
            }
            What::Leaf { kind, number, triangle } => {
                let foliage = &self.standing.tree.foliage[kind as usize];
                let blade = &foliage.blade;
                let t = blade.indices.as_chunks::<3>().0[triangle as usize].map(|i| i as usize);
                let node = foliage.leaves[number as usize].node;
                let label = if foliage.woody { Label::Wood(node) } else { Label::Leaf(node) };
                (&blade.positions, &blade.normals, &blade.uvs, t, label)
            }
        };
        let mix = |of: &[Vec3]| of[i] * weights[0] + of[j] * weights[1] + of[k] * weights[2];
        let point = mix(positions);
        let below = |i: usize| normals[i] * (positions[i] - point).dot(normals[i]).max(0.0);
        let [p, q, r] = [i, j, k].map(|i| Vec2::from(uvs[i]));
        Corners {
            point,
            lift: below(i) * weights[0] + below(j) * weights[1] + below(k) * weights[2],
            edges: [positions[j] - positions[i], positions[k] - positions[i]],
            normal: mix(normals),
            uv: (p * weights[0] + q * weights[1] + r * weights[2]).into(),
            uv_edges: [q - p, r - p],
            label,
        }
    }
}

/// Points that what is seen of a tree lies between: all vertices of the wood, and of each copy of a
/// leaf those that are farthest in one of 26 directions.
pub fn points(tree: &Dressed) -> impl Iterator<Item = Vec3> + Clone + '_ {
    let leaves = tree.foliage.iter().flat_map(|foliage| {
        let outermost = outermost(&foliage.blade.positions);
        foliage.leaves.iter().flat_map(move |leaf| {
            let outermost = outermost.clone();
            outermost.into_iter().map(move |p| world_from_blade(leaf, p))
        })
    });
    tree.wood.positions.iter().copied().chain(leaves)
}

/// The points that are farthest towards the faces, edges and corners of a cube.
fn outermost(points: &[Vec3]) -> Vec<Vec3> {
    let side = |i: i32| (i - 1) as f32;
    let directions = (0..27).map(|i| Vec3::new(side(i % 3), side(i / 3 % 3), side(i / 9)));
    let mut found: Vec<Vec3> = Vec::new();
    for direction in directions {
        let farther = |best: Vec3, &p: &Vec3| if direction.dot(p - best) > 0.0 { p } else { best };
        if let Some((&first, rest)) = points.split_first() {
            let one = rest.iter().fold(first, farther);
            if !found.contains(&one) {
                found.push(one);
            }
        }
    }
    found
}

/// What a triangle says of a place on it.
struct Corners {
    point: Vec3,
    /// From there to the round surface that the normals speak of: the mean of how far the planes
    /// square to them at the corners lie above. Without it faces that are turned away from the sun
    /// would stand out as dark where the round surface is still lit (Hanika 2021, "Hacking the shadow terminator").
    lift: Vec3,
    edges: [Vec3; 2],
    normal: Vec3,
    uv: [f32; 2],
    uv_edges: [Vec2; 2],
    label: Label,
}

impl<'a> Look<'a> {
    fn new(material: &'a Material) -> Result<Self, RenderError> {
        let name = &material.name;
        let texture = |image: &'a Option<Arc<Image>>, is_srgb, what| {
            image.as_ref().map(|image| Texture::new(image, is_srgb, name, what)).transpose()
        };
        Ok(Self {
            material,
            color: texture(&material.color_image, true, "colour")?,
            normal: texture(&material.normal_image, false, "normal")?,
            roughness: texture(&material.roughness_image, false, "roughness")?,
            cutoff: material.alpha_cutoff,
        })
    }

    fn bsdf(&self, uv: [f32; 2]) -> Bsdf {
        let color = Vec4::from(self.material.color).truncate();
        let albedo = color * self.color.map_or(Vec3::ONE, |texture| texture.sample(uv).truncate());
        let roughness =
            self.material.roughness * self.roughness.map_or(1.0, |texture| texture.sample(uv).x);
        Bsdf {
            albedo: albedo.clamp(Vec3::ZERO, Vec3::ONE),
            translucency: self.material.translucency.clamp(0.0, 1.0),
            coat: Some(Ggx::new(roughness)),
        }
    }

    /// The normal with what the picture of normals says.
    fn bump(&self, uv: [f32; 2], normal: Vec3, along_u: Vec3, along_v: Vec3) -> Vec3 {
        let Some(texture) = self.normal else { return normal };
        let square = |d: Vec3| (d - normal * normal.dot(d)).try_normalize();
        let (Some(u), Some(v)) = (square(along_u), square(along_v)) else { return normal };
        let bent = texture.sample(uv).truncate() * 2.0 - 1.0;
        (u * bent.x + v * bent.y + normal * bent.z.max(0.05)).try_normalize().unwrap_or(normal)
    }
}

impl Surface {
    fn new(point: Vec3, flat: Vec3, shading: Vec3, bsdf: Bsdf, label: Label, tree: usize) -> Self {
        let (tangent, bitangent) = shading.any_orthonormal_pair();
        let frame = [tangent, bitangent, shading];
        Self { point, lift: Vec3::ZERO, normal: flat, frame, bsdf, label, tree }
    }

    /// The direction in which shading thinks the surface faces.
    pub(crate) fn facing(&self) -> Vec3 {
        self.frame[2]
    }

    pub(crate) fn to_local(self, w: Vec3) -> Vec3 {
        Vec3::from_array(self.frame.map(|axis| axis.dot(w)))
    }

    pub(crate) fn to_world(self, w: Vec3) -> Vec3 {
        let [t, b, n] = self.frame;
        t * w.x + b * w.y + n * w.z
    }

    /// Does the surface agree with shading about the side a direction is on?
    pub(crate) fn agrees(&self, world: Vec3, local: Vec3) -> bool {
        world.dot(self.normal) * local.z > 0.0
    }

    /// A ray that leaves the surface, on the side it goes to.
    pub(crate) fn leave(&self, direction: Vec3) -> Ray {
        // Beyond the rounding of positions and of intersections so far from the origin.
        let gap = 2e-5 * self.point.abs().max_element().max(0.5);
        let side = if direction.dot(self.normal) < 0.0 { -gap } else { gap };
        Ray::new(self.point + self.lift + self.normal * side, direction)
    }
}
