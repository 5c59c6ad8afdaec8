//! The parts of a contact law.

use grains_contact::{CohesionArea, Memory, Tear};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The elastic force of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Normal {
    /// k_n δ; takes normal_stiffness.
    #[default]
    Linear,
    /// (4/3) E* √(R* δ) δ of elastic spheres; takes Young's moduli and Poisson's ratios of the materials, or effective_modulus.
    Hertz,
    /// Hertz less the constant pull 2π w R*: small, stiff adhesive spheres (Derjaguin, Muller and Toporov 1975).
    Dmt,
    /// Large, soft adhesive spheres (Johnson, Kendall and Roberts 1971), which hold on to each other over a gap.
    Jkr {
        /// Where bodies that are pulled apart let go.
        #[serde(default)]
        tear: Tear,
    },
    /// Hertz less a pull by the area of contact.
    Sjkr {
        /// Cohesion energy density (J/m³).
        #[schemars(extend("minimum" = 0))]
        energy_density: f64,
        /// Definition of the area; codes differ by factors of two under one name.
        area: CohesionArea,
    },
    /// Springs that load along normal_stiffness and unload along a steeper line, which gives the restitution without a dashpot
    /// (Walton and Braun 1986; Luding 2008).
    ElasticPlastic {
        /// Stiffness of the adhesive branch (N/m).
        #[serde(default)]
        #[schemars(extend("minimum" = 0))]
        adhesive_stiffness: f64,
    },
}

/// How a contact resists sliding; friction caps the force either way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Tangential {
    /// Spring and dashpot with a memory of the displacement (Wachs 2009, eqs 15-17).
    Spring {
        /// Tangential over normal stiffness k_t/k_n (-); 2/7 gives equal periods for spheres.
        #[serde(default = "two_sevenths")]
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [0.01, 2]))]
        stiffness_ratio: f64,
        /// Tangential over normal damping rate γ_t/γ_n (-).
        #[serde(default = "half")]
        #[schemars(extend("minimum" = 0, "x-plausible" = [0, 10]))]
        damping_ratio: f64,
    },
    /// Spring of stiffness 8 G* a and dashpot, for Hertzian contacts (Mindlin 1949); takes the materials' elastic constants, or
    /// effective_shear_modulus.
    Mindlin {
        /// What the contact remembers.
        #[serde(default)]
        memory: Memory,
        /// Tangential over normal damping rate γ_t/γ_n (-); by default √(k_t/(dF/dδ)), the same share of the critical.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("minimum" = 0, "x-plausible" = [0, 10]))]
        damping_ratio: Option<f64>,
    },
    /// Memoryless viscous force −2 γ_t m v_t (Rakotonirina 2016, eqs 3.20-3.21).
    Viscous {
        /// Tangential damping rate γ_t (1/s).
        #[schemars(extend("minimum" = 0))]
        gamma_t: f64,
    },
    /// Memoryless force −(k_t τ_c + η_t) v_t, τ_c the contact time (Srinivasan 2019, eqs 3.43-3.47).
    ContactTime {
        /// Tangential over normal stiffness k_t/k_n (-).
        #[serde(default = "two_sevenths")]
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [0.01, 2]))]
        stiffness_ratio: f64,
    },
}

/// How a contact resists rolling, up to a torque of the rolling friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Rolling {
    /// Spring and dashpot with a memory of the angle rolled: bodies stand on slopes (Ai et al. 2011, model C).
    Spring {
        /// Squared frequency of the rolling spring over that of the normal spring (-).
        #[serde(default = "two_sevenths")]
        #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-plausible" = [0.01, 1]))]
        stiffness_ratio: f64,
        /// Share of the critical damping (-).
        #[serde(default = "rolling_damping")]
        #[schemars(extend("minimum" = 0, "maximum" = 1))]
        damping_ratio: f64,
    },
    /// Memoryless viscous torque −2 γ_t m R² ω: bodies creep down slopes.
    Viscous {},
    /// Spring and dashpot in the displacement rolled, k R² and γ R² in the angle (LAMMPS sds).
    Sds {
        /// Stiffness k (N/m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        stiffness: f64,
        /// Dashpot γ (N s/m).
        #[serde(default)]
        #[schemars(extend("minimum" = 0))]
        dashpot: f64,
    },
    /// Spring k_t R² without a dashpot (LIGGGHTS epsd2); takes a tangential spring.
    Epsd2 {},
    /// The whole torque against any rolling (LIGGGHTS cdt): heaps creep.
    Constant {},
}

impl Default for Rolling {
    fn default() -> Self {
        Self::Spring { stiffness_ratio: two_sevenths(), damping_ratio: rolling_damping() }
    }
}

fn rolling_damping() -> f64 {
    0.3
}

/// How two bodies pull at each other over a gap, beside their contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Attraction {
    /// Not at all.
    #[default]
    None,
    /// By bridges of liquid of one volume, which form on contact and break at a gap of (1 + θ/2) V^(1/3).
    LiquidBridge {
        /// Volume V of a bridge (m³).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-21, 1e-6]))]
        volume: f64,
        /// Surface tension (N/m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-3, 1]))]
        surface_tension: f64,
        /// Contact angle θ (rad).
        #[serde(default)]
        #[schemars(extend("minimum" = 0, "maximum" = std::f64::consts::FRAC_PI_2))]
        contact_angle: f64,
        /// Force over the gap.
        #[serde(default)]
        force: Capillary,
        /// Viscosity of the liquid (Pa s).
        #[serde(default)]
        #[schemars(extend("minimum" = 0, "x-plausible" = [0, 100]))]
        viscosity: f64,
        /// Smallest gap over the effective radius that viscous forces see, the roughness (-).
        #[serde(default = "roughness")]
        #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
        min_gap: f64,
        /// Thickness of the films on both bodies (m), which form a bridge where they meet.
        #[serde(default)]
        #[schemars(extend("minimum" = 0))]
        film: f64,
    },
    /// By bridges of liquid from the films of the two materials, which get it back where they break, at a gap of
    /// (1 + θ/2) V^(1/3).
    FilmBridge {
        /// Share of either film that a bridge takes (-); by default the cap that the other body sees (Shi and McCarthy 2008).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
        share: Option<f64>,
        /// Largest volume of a bridge (m³), half from either body; by default twice the largest there is at the
        /// beginning.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-21, 1e-6]))]
        max_volume: Option<f64>,
        /// Share of a broken bridge that stays on a wall (-); particles get half each.
        #[serde(default = "half")]
        #[schemars(extend("minimum" = 0, "maximum" = 1))]
        wall_share: f64,
        /// Where a bridge forms.
        #[serde(default)]
        formation: Formation,
        /// Surface tension (N/m).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-3, 1]))]
        surface_tension: f64,
        /// Contact angle θ (rad).
        #[serde(default)]
        #[schemars(extend("minimum" = 0, "maximum" = std::f64::consts::FRAC_PI_2))]
        contact_angle: f64,
        /// Force over the gap.
        #[serde(default)]
        force: Capillary,
        /// Viscosity of the liquid (Pa s).
        #[serde(default)]
        #[schemars(extend("minimum" = 0, "x-plausible" = [0, 100]))]
        viscosity: f64,
        /// Smallest gap over the effective radius that viscous forces see, the roughness (-).
        #[serde(default = "roughness")]
        #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
        min_gap: f64,
    },
    /// By van der Waals forces of surfaces with asperities.
    VanDerWaals {
        /// Hamaker constant (J).
        #[schemars(extend("exclusiveMinimum" = 0, "x-plausible" = [1e-21, 1e-18]))]
        hamaker: f64,
        /// Radius of asperities (m); 0 for smooth bodies.
        #[serde(default)]
        #[schemars(extend("minimum" = 0, "x-plausible" = [0, 1e-5]))]
        asperity: f64,
        /// Gap below which the force grows no more (m).
        #[serde(default = "inner_cut_off")]
        #[schemars(extend("exclusiveMinimum" = 0))]
        inner: f64,
        /// Gap beyond which there is none (m).
        #[schemars(extend("exclusiveMinimum" = 0))]
        outer: f64,
    },
}

/// Where a bridge forms that films feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Formation {
    /// Where bodies touch.
    #[default]
    Contact,
    /// Where their films touch.
    Films,
}

/// Force of a liquid bridge over the gap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Capillary {
    /// Full fit of Willett et al. (2000), for contact angles up to 50 degrees.
    #[default]
    Willett,
    /// Its short form, 2π R γ cos θ/(1 + 1.05 s + 2.5 s²), s = h √(R/V).
    WillettShort,
    /// Rabinovich et al. (2005), corrected by Lambert.
    Rabinovich,
}

fn roughness() -> f64 {
    0.01
}

fn inner_cut_off() -> f64 {
    4e-10
}

impl Tangential {
    /// That of a case that gives none: a spring, of Mindlin's stiffness where the contact is Hertzian.
    pub(crate) fn of(normal: &Normal) -> Self {
        match normal.is_hertzian() {
            true => Self::Mindlin { memory: Memory::default(), damping_ratio: None },
            false => Self::Spring { stiffness_ratio: two_sevenths(), damping_ratio: half() },
        }
    }
}

impl Normal {
    /// Whether it is that of elastic spheres, with adhesion or without.
    pub fn is_hertzian(&self) -> bool {
        !matches!(self, Self::Linear | Self::ElasticPlastic { .. })
    }

    /// Whether it takes a work of adhesion.
    pub fn takes_work(&self) -> bool {
        matches!(self, Self::Dmt | Self::Jkr { .. })
    }
}

fn two_sevenths() -> f64 {
    2.0 / 7.0
}

fn half() -> f64 {
    0.5
}
