// A multiplier of the iCE40, as yosys packs it: an abstract product, its register, and an adder of C and D.
// Other ways to use the cell stay as they are.
module SB_MAC16 (
    input CLK, CE, AHOLD, BHOLD, CHOLD, DHOLD, IRSTTOP, IRSTBOT, ORSTTOP, ORSTBOT, OLOADTOP, OLOADBOT, ADDSUBTOP,
    input ADDSUBBOT, OHOLDTOP, OHOLDBOT, CI, ACCUMCI, SIGNEXTIN,
    input [15:0] A, B, C, D,
    output [31:0] O,
    output CO, ACCUMCO, SIGNEXTOUT
);
  parameter NEG_TRIGGER = 0, C_REG = 0, A_REG = 0, B_REG = 0, D_REG = 0, TOP_8x8_MULT_REG = 0, BOT_8x8_MULT_REG = 0;
  parameter PIPELINE_16x16_MULT_REG1 = 0, PIPELINE_16x16_MULT_REG2 = 0, TOPOUTPUT_SELECT = 0, TOPADDSUB_LOWERINPUT = 0;
  parameter TOPADDSUB_UPPERINPUT = 0, TOPADDSUB_CARRYSELECT = 0, BOTOUTPUT_SELECT = 0, BOTADDSUB_LOWERINPUT = 0;
  parameter BOTADDSUB_UPPERINPUT = 0, BOTADDSUB_CARRYSELECT = 0, MODE_8x8 = 0, A_SIGNED = 0, B_SIGNED = 0;
  parameter _TECHMAP_CONSTVAL_CE_ = 1'bx, _TECHMAP_CONSTVAL_IRSTTOP_ = 1'bx, _TECHMAP_CONSTVAL_IRSTBOT_ = 1'bx;
  parameter _TECHMAP_CONSTVAL_OLOADTOP_ = 1'bx, _TECHMAP_CONSTVAL_OLOADBOT_ = 1'bx;
  parameter _TECHMAP_CONSTVAL_ADDSUBTOP_ = 1'bx, _TECHMAP_CONSTVAL_ADDSUBBOT_ = 1'bx;

  localparam BARE = !PIPELINE_16x16_MULT_REG1 && !TOP_8x8_MULT_REG && !BOT_8x8_MULT_REG;
  localparam REGISTERED = PIPELINE_16x16_MULT_REG1 && TOP_8x8_MULT_REG && BOT_8x8_MULT_REG && _TECHMAP_CONSTVAL_CE_ === 1'b1 && _TECHMAP_CONSTVAL_IRSTTOP_ === 1'b0
      && _TECHMAP_CONSTVAL_IRSTBOT_ === 1'b0;
  localparam ADDED = TOPOUTPUT_SELECT == 0 && BOTOUTPUT_SELECT == 0 && TOPADDSUB_LOWERINPUT == 2
      && BOTADDSUB_LOWERINPUT == 2 && TOPADDSUB_UPPERINPUT == 1 && BOTADDSUB_UPPERINPUT == 1
      && TOPADDSUB_CARRYSELECT == 3 && BOTADDSUB_CARRYSELECT == 0 && _TECHMAP_CONSTVAL_OLOADTOP_ === 1'b0
      && _TECHMAP_CONSTVAL_OLOADBOT_ === 1'b0 && _TECHMAP_CONSTVAL_ADDSUBTOP_ === 1'b0
      && _TECHMAP_CONSTVAL_ADDSUBBOT_ === 1'b0;
  localparam PLAIN = TOPOUTPUT_SELECT == 3 && BOTOUTPUT_SELECT == 3;
  wire _TECHMAP_FAIL_ = NEG_TRIGGER || A_REG || B_REG || C_REG || D_REG || PIPELINE_16x16_MULT_REG2 || MODE_8x8
      || !(BARE || REGISTERED) || !(ADDED || PLAIN);

  wire [31:0] made;
  product #(.A_SIGNED(A_SIGNED), .B_SIGNED(B_SIGNED)) product (.A(A), .B(B), .Y(made));
  wire [31:0] stage;
  generate
    if (BARE) assign stage = made;
    else begin
      reg [31:0] held = 0;  // as all registers of the iCE40 begin
      always @(posedge CLK) held <= made;
      assign stage = held;
    end
  endgenerate
  assign O = ADDED ? stage + {C, D} : stage;
endmodule
