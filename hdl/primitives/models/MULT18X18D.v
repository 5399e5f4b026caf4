// MULT18X18D of the ECP5 as a multiplier: input, pipeline and output registers, each with a clock, an enable and a
// synchronous reset of its own, or none; words signed or not.  Cascades (SRI, SRO, RO), the C input and asynchronous
// resets are not modelled: parameters and inputs that ask for them are fatal.  Latency: the sum of the registers.
// There are no pins for SRI: these have wires from the cell beside them alone, and no router can bring them a constant.
/* verilator lint_save */
/* verilator lint_off UNUSED */  // pins and parameters of modes that are not modelled
/* verilator lint_off DECLFILENAME */  // the cell's registers are in this file
module MULT18X18D (
  input
    A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0,
    B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0,
    C17, C16, C15, C14, C13, C12, C11, C10, C9, C8, C7, C6, C5, C4, C3, C2, C1, C0,
    SIGNEDA, SIGNEDB, SOURCEA, SOURCEB,
    CLK0, CLK1, CLK2, CLK3, CE0, CE1, CE2, CE3, RST0, RST1, RST2, RST3,
  output
    P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18, P17, P16, P15,
    P14, P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0,
    SIGNEDP
);
  parameter REG_INPUTA_CLK = "NONE", REG_INPUTA_CE = "CE0", REG_INPUTA_RST = "RST0";
  parameter REG_INPUTB_CLK = "NONE", REG_INPUTB_CE = "CE0", REG_INPUTB_RST = "RST0";
  parameter REG_INPUTC_CLK = "NONE", REG_INPUTC_CE = "CE0", REG_INPUTC_RST = "RST0";
  parameter REG_PIPELINE_CLK = "NONE", REG_PIPELINE_CE = "CE0", REG_PIPELINE_RST = "RST0";
  parameter REG_OUTPUT_CLK = "NONE", REG_OUTPUT_CE = "CE0", REG_OUTPUT_RST = "RST0";
  parameter CLK0_DIV = "ENABLED", CLK1_DIV = "ENABLED", CLK2_DIV = "ENABLED", CLK3_DIV = "ENABLED";
  parameter HIGHSPEED_CLK = "NONE", GSR = "ENABLED", CAS_MATCH_REG = "FALSE", SOURCEB_MODE = "B_SHIFT";
  parameter MULT_BYPASS = "DISABLED", RESETMODE = "SYNC";

  wire [17:0] a, b;
  wire sign_a, sign_b, unused_a, unused_b;
  MULT18X18D_register #(20, REG_INPUTA_CLK, REG_INPUTA_CE, REG_INPUTA_RST) input_a (
    {1'b0, SIGNEDA,
      A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0},
    {CLK3, CLK2, CLK1, CLK0}, {CE3, CE2, CE1, CE0}, {RST3, RST2, RST1, RST0}, {unused_a, sign_a, a});
  MULT18X18D_register #(20, REG_INPUTB_CLK, REG_INPUTB_CE, REG_INPUTB_RST) input_b (
    {1'b0, SIGNEDB,
      B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0},
    {CLK3, CLK2, CLK1, CLK0}, {CE3, CE2, CE1, CE0}, {RST3, RST2, RST1, RST0}, {unused_b, sign_b, b});

  wire signed [18:0] factor_a = {sign_a & a[17], a}, factor_b = {sign_b & b[17], b};
  wire signed [37:0] product = factor_a * factor_b;
  wire [36:0] middle, last;
  MULT18X18D_register #(37, REG_PIPELINE_CLK, REG_PIPELINE_CE, REG_PIPELINE_RST) pipeline (
    {sign_a | sign_b, product[35:0]},
    {CLK3, CLK2, CLK1, CLK0}, {CE3, CE2, CE1, CE0}, {RST3, RST2, RST1, RST0}, middle);
  MULT18X18D_register #(37, REG_OUTPUT_CLK, REG_OUTPUT_CE, REG_OUTPUT_RST) result (
    middle,
    {CLK3, CLK2, CLK1, CLK0}, {CE3, CE2, CE1, CE0}, {RST3, RST2, RST1, RST0}, last);
  assign {SIGNEDP,
    P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18, P17, P16, P15,
    P14, P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0} = last;

  initial
    if (REG_INPUTC_CLK != "NONE" || HIGHSPEED_CLK != "NONE" || CAS_MATCH_REG != "FALSE" || SOURCEB_MODE != "B_SHIFT"
        || MULT_BYPASS != "DISABLED" || RESETMODE != "SYNC" || CLK0_DIV != "ENABLED" || CLK1_DIV != "ENABLED"
        || CLK2_DIV != "ENABLED" || CLK3_DIV != "ENABLED")
      $fatal(1, "%m: a mode of MULT18X18D that is not modelled");
  always @(SOURCEA or SOURCEB)
    if (SOURCEA === 1'b1 || SOURCEB === 1'b1) $fatal(1, "%m: MULT18X18D: the shift inputs are not modelled");
endmodule

// One of its registers, or a wire.  Configured parts start from zero.
module MULT18X18D_register #(parameter BITS = 1, CLK = "NONE", CE = "CE0", RST = "RST0") (
  input [BITS-1:0] d, input [3:0] clk, ce, rst, output [BITS-1:0] q
);
  wire clock = CLK == "CLK0" ? clk[0] : CLK == "CLK1" ? clk[1] : CLK == "CLK2" ? clk[2] : clk[3];
  wire enable = CE == "CE0" ? ce[0] : CE == "CE1" ? ce[1] : CE == "CE2" ? ce[2] : ce[3];
  wire reset = RST == "RST0" ? rst[0] : RST == "RST1" ? rst[1] : RST == "RST2" ? rst[2] : rst[3];
  reg [BITS-1:0] word;
  initial word = 0;
  always @(posedge clock) word <= reset === 1'b1 ? 0 : enable ? d : word;
  assign q = CLK == "NONE" ? d : word;
  initial
    if (CLK != "NONE" && CLK != "CLK0" && CLK != "CLK1" && CLK != "CLK2" && CLK != "CLK3")
      $fatal(1, "%m: MULT18X18D: no such clock: %s", CLK);
endmodule
/* verilator lint_restore */
