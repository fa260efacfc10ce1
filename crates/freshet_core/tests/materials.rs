//! Equations of state and materials.

use freshet_core::equation_of_state::{EquationOfState, PressureLaw};
use freshet_core::material::Material;

const ALL: [EquationOfState; 5] = [
    EquationOfState::IdealGas { stiffness: 3.0 },
    EquationOfState::Desbrun { stiffness: 120.0 },
    EquationOfState::Harada { reference_pressure: 50.0, stiffness: 7.5 },
    EquationOfState::Tait { sound_speed: 30.0, exponent: 7.0 },
    EquationOfState::Linear { sound_speed: 12.0 },
];

#[test]
fn pressure_at_rest_density() {
    let rest = ALL.map(|equation| equation.pressure(1000.0, 1000.0));
    assert_eq!(rest, [3000.0, 0.0, 50.0, 0.0, 0.0]);
}

#[test]
fn the_slope_at_rest_density_is_the_square_of_the_speed_of_sound() {
    for equation in ALL {
        for rest_density in [1.2, 1000.0, 13_534.0] {
            let step = 1e-5 * rest_density;
            let rise = equation.pressure(rest_density, rest_density + step)
                - equation.pressure(rest_density, rest_density - step);
            let slope = rise / (2.0 * step);
            // Tait's third derivative leaves (n-1)(n-2)/6 * 1e-10 = 5e-10, rounding of the difference 1e-10.
            let error = slope / equation.sound_speed(rest_density).powi(2) - 1.0;
            assert!(error.abs() < 1e-8, "{} at {rest_density}: {error}", equation.name());
        }
    }
}

#[test]
fn tait_at_one_per_cent() {
    let tait = EquationOfState::Tait { sound_speed: 30.0, exponent: 7.0 };
    // 1000 * 900 / 7 * (1.01^7 - 1), worked by hand: 1.01^7 = 1.0721353521.
    assert!((tait.pressure(1000.0, 1010.0) - 9_274.545_3).abs() < 1e-3);
    // Stiffer than the linear law in compression, softer in tension.
    let linear = EquationOfState::Linear { sound_speed: 30.0 };
    for density in [990.0, 1010.0] {
        assert!(tait.pressure(1000.0, density) > linear.pressure(1000.0, density));
    }
}

#[test]
fn negative_pressure_is_clamped_only_on_request_and_nan_never_hidden() {
    for equation in ALL {
        let (free, clamped) =
            (PressureLaw { equation, clamp_negative: false }, PressureLaw { equation, clamp_negative: true });
        for density in [0.0, 500.0, 999.0, 1000.0, 1001.0, 2000.0] {
            let pressure = equation.pressure(1000.0, density);
            assert_eq!(free.pressure(1000.0, density), pressure);
            assert_eq!(clamped.pressure(1000.0, density), pressure.max(0.0), "{} at {density}", equation.name());
        }
        assert!(clamped.pressure(1000.0, f64::NAN).is_nan());
    }
    let tait = ALL[3];
    assert!(tait.pressure(1000.0, 999.0) < 0.0);
}

#[test]
fn parameters_out_of_range_are_named() {
    use EquationOfState::*;
    for equation in ALL {
        assert_eq!(equation.validate(), Ok(()));
    }
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        let field = |equation: EquationOfState| equation.validate().unwrap_err().field;
        assert_eq!(field(IdealGas { stiffness: bad }), "stiffness");
        assert_eq!(field(Desbrun { stiffness: bad }), "stiffness");
        assert_eq!(field(Harada { reference_pressure: 0.0, stiffness: bad }), "stiffness");
        assert_eq!(field(Harada { reference_pressure: bad, stiffness: 1.0 }), "reference_pressure");
        assert_eq!(field(Tait { sound_speed: bad, exponent: 7.0 }), "sound_speed");
        assert_eq!(field(Tait { sound_speed: 1.0, exponent: bad }), "exponent");
        assert_eq!(field(Linear { sound_speed: bad }), "sound_speed");
    }
    let law = PressureLaw { equation: Linear { sound_speed: 0.0 }, clamp_negative: true };
    assert_eq!(law.validate().unwrap_err().field, "equation.sound_speed");
}

#[test]
fn presets_are_valid_and_found_by_name() {
    let presets = Material::presets();
    assert!(presets.iter().map(|material| material.name.as_str()).eq(Material::PRESETS));
    for material in presets {
        assert_eq!(material.validate(), Ok(()));
        assert_eq!(Material::preset(&material.name), Ok(material));
    }
    // A litre of water weighs a kilogram.
    assert_eq!(Material::water().rest_density, 1000.0);
}

#[test]
fn an_unknown_preset_lists_the_known_ones() {
    let message = Material::preset("beer").unwrap_err().to_string();
    assert!(message.contains("beer"), "{message}");
    for name in Material::PRESETS {
        assert!(message.contains(name), "{message}");
    }
}

#[test]
fn bad_materials_are_refused_with_the_field() {
    let field = |change: fn(&mut Material)| {
        let mut material = Material::water();
        change(&mut material);
        material.validate().unwrap_err().field
    };
    assert_eq!(field(|m| m.rest_density = 0.0), "rest_density");
    assert_eq!(field(|m| m.rest_density = 50_001.0), "rest_density");
    assert_eq!(field(|m| m.rest_density = f32::NAN), "rest_density");
    assert_eq!(field(|m| m.dynamic_viscosity = -1e-9), "dynamic_viscosity");
    assert_eq!(field(|m| m.dynamic_viscosity = f32::INFINITY), "dynamic_viscosity");
    assert_eq!(field(|m| m.name = " ".into()), "name");
}

#[test]
fn both_survive_a_file_and_unknown_fields_do_not() {
    for material in Material::presets() {
        let text = ron::to_string(&material).unwrap();
        assert_eq!(ron::from_str::<Material>(&text).unwrap(), material);
    }
    for equation in ALL {
        let law = PressureLaw { equation, clamp_negative: true };
        assert_eq!(ron::from_str::<PressureLaw>(&ron::to_string(&law).unwrap()).unwrap(), law);
    }
    assert!(ron::from_str::<Material>("(name:\"x\",rest_density:1.0,dynamic_viscosity:0.0,colour:1)").is_err());
    assert!(ron::from_str::<EquationOfState>("Linear(sound_speed:1.0,exponent:7.0)").is_err());
}
