"""The publications that effects are taken from, each cited in full once."""

JIANG = (
    "Jiang, Ding, Wu, Bai, Shao and Zi: Energy Dissipation Characteristics and Parameter Identification of "
    "Symmetrically Coated Damping Structure of Pipelines under Different Temperature Environment, Symmetry 12(8), 1283 "
    "(2020), doi 10.3390/sym12081283"
)
IWAN = (
    "Iwan: A Distributed-Element Model for Hysteresis and Its Steady-State Dynamic Response, Journal of Applied "
    "Mechanics 33(4), 893-900 (1966)"
)
JENKINS = (
    "Jenkins: Analysis of the stress-strain relationships in reactor grade graphite, British Journal of Applied "
    "Physics 13, 30-32 (1962)"
)
MASING = (
    "Masing: Eigenspannungen und Verfestigung beim Messing, Proceedings of the 2nd International Congress for Applied "
    "Mechanics, Zürich (1926)"
)
GAUL = "Gaul and Nitsche: The Role of Friction in Mechanical Joints, Applied Mechanics Reviews 54(2), 93-106 (2001)"
BOGRAD = (
    "Bograd, Reuss, Schmidt, Gaul and Mayer: Modeling the dynamics of mechanical joints, Mechanical Systems and Signal "
    "Processing 25(8), 2801-2826 (2011)"
)
NAYFEH = "Nayfeh and Mook: Nonlinear Oscillations, Wiley (1979)"
KOVACIC = "Kovacic and Brennan (eds.): The Duffing Equation: Nonlinear Oscillators and their Behaviour, Wiley (2011)"
WORDEN = (
    "Worden and Tomlinson: Nonlinearity in Structural Dynamics: Detection, Identification and Modelling, Institute of "
    "Physics Publishing (2001)"
)
SHAW = (
    "Shaw and Holmes: A periodically forced piecewise linear oscillator, Journal of Sound and Vibration 90(1), 129-155 "
    "(1983)"
)
INMAN = "Inman: Engineering Vibration, 4th edition, Pearson (2014)"
FERRY = "Ferry: Viscoelastic Properties of Polymers, 3rd edition, Wiley (1980)"
NASHIF = "Nashif, Jones and Henderson: Vibration Damping, Wiley (1985)"
BAGLEY = (
    "Bagley and Torvik: A Theoretical Basis for the Application of Fractional Calculus to Viscoelasticity, Journal of "
    "Rheology 27(3), 201-210 (1983)"
)
GIBSON = "Gibson and Ashby: Cellular Solids: Structure and Properties, 2nd edition, Cambridge University Press (1997)"
JUNKER = "Junker: New Criteria for Self-Loosening of Fasteners Under Vibration, SAE Technical Paper 690055 (1969)"
SPENCER = (
    "Spencer, Dyke, Sain and Carlson: Phenomenological Model for Magnetorheological Dampers, Journal of Engineering "
    "Mechanics 123(3), 230-238 (1997)"
)
LOMIENTO = (
    "Lomiento, Bonessio and Benzoni: Friction Model for Sliding Bearings under Seismic Excitation, Journal of "
    "Earthquake Engineering 17(8), 1162-1191 (2013)"
)
DIXON = "Dixon: The Shock Absorber Handbook, 2nd edition, Wiley (2007)"
EWINS = "Ewins: Modal Testing: Theory, Practice and Application, 2nd edition, Research Studies Press (2000)"
DOEBELIN = "Doebelin: Measurement Systems: Application and Design, 5th edition, McGraw-Hill (2004)"
OPPENHEIM = "Oppenheim, Willsky and Nawab: Signals and Systems, 2nd edition, Prentice Hall (1997)"
NORDIN = (
    "Nordin, Galic and Gutman: New models for backlash and gear play, International Journal of Adaptive Control and "
    "Signal Processing 11(1), 49-63 (1997)"
)
ARMSTRONG = (
    "Armstrong-Hélouvry, Dupont and Canudas de Wit: A survey of models, analysis tools and compensation methods for "
    "the control of machines with friction, Automatica 30(7), 1083-1138 (1994)"
)
WILLIAMS = (
    "Williams, Landel and Ferry: The Temperature Dependence of Relaxation Mechanisms in Amorphous Polymers and Other "
    "Glass-forming Liquids, Journal of the American Chemical Society 77(14), 3701-3707 (1955)"
)
ANDERSSON = (
    "Andersson, Söderberg and Björklund: Friction Models for Sliding Dry, Boundary and Mixed Lubricated Contacts, "
    "Tribology International 40(4), 580-587 (2007)"
)
SEGALMAN = (
    "Segalman: A Four-Parameter Iwan Model for Lap-Type Joints, Journal of Applied Mechanics 72(5), 752-760 (2005)"
)
WEN = (
    "Wen: Method for Random Vibration of Hysteretic Systems, Journal of the Engineering Mechanics Division 102(2), "
    "249-263 (1976)"
)
DAHL = "Dahl: A Solid Friction Model, Aerospace Corporation Report TOR-0158(3107-18)-1 (1968)"
BABER = (
    "Baber and Noori: Random Vibration of Degrading, Pinching Systems, Journal of Engineering Mechanics 111(8), "
    "1010-1026 (1985)"
)
FOLIENTE = (
    "Foliente: Hysteresis Modeling of Wood Joints and Structural Systems, Journal of Structural Engineering 121(6), "
    "1013-1022 (1995)"
)
OLSSON = (
    "Olsson, Åström, Canudas de Wit, Gäfvert and Lischinsky: Friction Models and Friction Compensation, European "
    "Journal of Control 4(3), 176-195 (1998)"
)
BO = (
    "Bo and Pavelescu: The friction-speed relation and its influence on the critical velocity of stick-slip motion, "
    "Wear 82(3), 277-289 (1982)"
)
FUNG = "Fung: Elasticity of soft tissues in simple elongation, American Journal of Physiology 213(6), 1532-1544 (1967)"
BAUER = "Bauer: Hydropneumatic Suspension Systems, Springer (2011)"
QUAGLIA = (
    "Quaglia and Sorli: Air Suspension Dimensionless Analysis and Design Procedure, Vehicle System Dynamics 35(6), "
    "443-475 (2001)"
)
KOELLER = (
    "Koeller: Applications of Fractional Calculus to the Theory of Viscoelasticity, Journal of Applied Mechanics "
    "51(2), 299-307 (1984)"
)
COLE = (
    "Cole and Cole: Dispersion and Absorption in Dielectrics I. Alternating Current Characteristics, Journal of "
    "Chemical Physics 9(4), 341-351 (1941)"
)
PARK = (
    "Park: Analytical modeling of viscoelastic dampers for structural and vibration control, International Journal of "
    "Solids and Structures 38(44-45), 8065-8092 (2001)"
)
KASAI = (
    "Kasai and Nishimura: Equivalent Linearization of Passive Control System Having Oil Damper Bi-linearly Dependent "
    "on Velocity, Journal of Structural and Construction Engineering (AIJ) 69(583), 47-54 (2004)"
)
AKCELYAN = (
    "Akcelyan, Lignos and Hikino: Adaptive Numerical Method Algorithms for Nonlinear Viscous and Bilinear Oil Damper "
    "Models Subjected to Dynamic Loading, Soil Dynamics and Earthquake Engineering 113, 488-502 (2018)"
)
SINGH = (
    "Singh, Kim and Ravindra: Linear analysis of automotive hydro-mechanical mount with emphasis on decoupler "
    "characteristics, Journal of Sound and Vibration 158(2), 219-243 (1992)"
)
REID = "Reid: Free vibration and hysteretic damping, Journal of the Royal Aeronautical Society 60, 283 (1956)"
HILL = (
    "Hill: The Utility of Ring Springs in Seismic Isolation Systems, PhD thesis, University of Canterbury, "
    "Christchurch (1995)"
)
CONSTANTINOU = (
    "Constantinou, Mokha and Reinhorn: Teflon Bearings in Base Isolation II: Modeling, Journal of Structural "
    "Engineering 116(2), 455-474 (1990)"
)
YANG = (
    "Yang, Chu and Menq: Stick-Slip-Separation Analysis and Non-Linear Stiffness and Damping Characterization of "
    "Friction Contacts Having Variable Normal Load, Journal of Sound and Vibration 210(4), 461-481 (1998)"
)
SHERIF = (
    "Sherif and Kossa: Relationship between Normal and Tangential Contact Stiffness of Nominally Flat Surfaces, Wear "
    "151(1), 49-62 (1991)"
)
WHITEMAN = (
    "Whiteman and Ferri: Displacement-Dependent Dry Friction Damping of a Beam-Like Structure, Journal of Sound and "
    "Vibration 198(3), 313-329 (1996)"
)
CHRISTOPOULOS = (
    "Christopoulos, Filiatrault and Folz: Seismic Response of Self-Centring Hysteretic SDOF Systems, Earthquake "
    "Engineering and Structural Dynamics 31(5), 1131-1150 (2002)"
)
DOLCE = (
    "Dolce, Cardone and Croatto: Frictional Behavior of Steel-PTFE Interfaces for Seismic Isolation, Bulletin of "
    "Earthquake Engineering 3(1), 75-99 (2005), doi 10.1007/s10518-005-0187-9"
)
AURICCHIO = (
    "Auricchio and Sacco: A One-Dimensional Model for Superelastic Shape-Memory Alloys with Different Elastic "
    "Properties between Austenite and Martensite, International Journal of Non-Linear Mechanics 32(6), 1101-1114 (1997)"
)
HUNT = (
    "Hunt and Crossley: Coefficient of Restitution Interpreted as Damping in Vibroimpact, Journal of Applied Mechanics "
    "42(2), 440-445 (1975)"
)
TSUJI = (
    "Tsuji, Tanaka and Ishida: Lagrangian numerical simulation of plug flow of cohesionless particles in a horizontal "
    "pipe, Powder Technology 71(3), 239-250 (1992)"
)
