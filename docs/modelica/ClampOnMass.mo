package ClampOnMass "A mass on a pipe clamp that was imported as an FMU, let go out of its rest"
  block ClampFMU "What a tool's FMU import makes of clamp.fmu: replace it by that"
    Modelica.Blocks.Interfaces.RealInput s(unit = "m") "flange.s";
    Modelica.Blocks.Interfaces.RealInput v(unit = "m/s") "flange.v";
    Modelica.Blocks.Interfaces.RealOutput f(unit = "N") "flange.f, the cut force into the clamp";
    parameter Real c(unit = "N/m") = 1.2e6 "A spring and a damper stand in for the clamp";
    parameter Real d(unit = "N.s/m") = 300;
  equation
    f = c * s + d * v;
  end ClampFMU;

  model Example "The clamp between a mass and the ground"
    Modelica.Mechanics.Translational.Components.Mass mass(m = 20, s(start = 1e-3, fixed = true), v(fixed = true));
    Modelica.Mechanics.Translational.Components.GeneralForceToPositionAdaptor flange(use_pder = true, use_pder2 = false)
      "Flange to signals: s and v out, f in; flange.f = f";
    ClampFMU clamp;
  equation
    connect(mass.flange_b, flange.flange);
    connect(flange.p, clamp.s);
    connect(flange.pder, clamp.v);
    connect(clamp.f, flange.f);
  end Example;
end ClampOnMass;
