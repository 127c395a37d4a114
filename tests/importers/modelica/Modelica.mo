package Modelica "So much of the standard library as the example uses, to check it without the library"
  package Blocks
    package Interfaces
      connector RealInput = input Real;
      connector RealOutput = output Real;
    end Interfaces;
  end Blocks;
  package Mechanics
    package Translational
      package Interfaces
        connector Flange_a
          Real s;
          flow Real f;
        end Flange_a;
        connector Flange_b
          Real s;
          flow Real f;
        end Flange_b;
      end Interfaces;
      package Components
        model Mass
          parameter Real m;
          Real s;
          Real v;
          Interfaces.Flange_a flange_a;
          Interfaces.Flange_b flange_b;
        equation
          s = flange_a.s;
          s = flange_b.s;
          v = der(s);
          m * der(v) = flange_a.f + flange_b.f;
        end Mass;
        model GeneralForceToPositionAdaptor
          parameter Boolean use_pder = true;
          parameter Boolean use_pder2 = true;
          Blocks.Interfaces.RealOutput p;
          Blocks.Interfaces.RealOutput pder;
          Blocks.Interfaces.RealInput f;
          Interfaces.Flange_a flange;
        equation
          p = flange.s;
          pder = der(flange.s);
          flange.f = f;
        end GeneralForceToPositionAdaptor;
      end Components;
    end Translational;
  end Mechanics;
end Modelica;
