// DP16KD of the ECP5: 2048 bytes of 9 bits behind two ports of 1, 2, 4, 9 or 18 bits, or, as a simple dual-port memory,
// written 36 bits wide by port A and read by port B (36 bits come out on DOB and DOA).  Reads are synchronous; REGMODE
// "OUTREG" puts an output register behind them.  A word that is read on one port while the other port writes it is X.
// Chip selects other than "0b000" and inverted controls are not modelled: they are fatal, and so is a reset in the
// asynchronous mode.
/* verilator lint_save */
/* verilator lint_off UNUSED */  // pins and parameters of other modes, and address bits that a mode does not use
module DP16KD (
  input
    DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2,
    DIA1, DIA0,
    ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0,
    CEA, OCEA, CLKA, WEA, RSTA, CSA2, CSA1, CSA0,
    DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2,
    DIB1, DIB0,
    ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0,
    CEB, OCEB, CLKB, WEB, RSTB, CSB2, CSB1, CSB0,
  output
    DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2,
    DOA1, DOA0,
    DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2,
    DOB1, DOB0
);
  parameter DATA_WIDTH_A = 18, DATA_WIDTH_B = 18, REGMODE_A = "NOREG", REGMODE_B = "NOREG";
  parameter WRITEMODE_A = "NORMAL", WRITEMODE_B = "NORMAL", CSDECODE_A = "0b000", CSDECODE_B = "0b000";
  parameter RESETMODE = "SYNC", ASYNC_RESET_RELEASE = "SYNC", GSR = "ENABLED", WID = 0;
  parameter CLKAMUX = "CLKA", CLKBMUX = "CLKB";
  parameter
    CEAMUX = "CEA", OCEAMUX = "OCEA", WEAMUX = "WEA", RSTAMUX = "RSTA", CEBMUX = "CEB", OCEBMUX = "OCEB",
    WEBMUX = "WEB", RSTBMUX = "RSTB";
  parameter [319:0]
    INITVAL_00 = 0, INITVAL_01 = 0, INITVAL_02 = 0, INITVAL_03 = 0, INITVAL_04 = 0, INITVAL_05 = 0,
    INITVAL_06 = 0, INITVAL_07 = 0, INITVAL_08 = 0, INITVAL_09 = 0, INITVAL_0A = 0, INITVAL_0B = 0,
    INITVAL_0C = 0, INITVAL_0D = 0, INITVAL_0E = 0, INITVAL_0F = 0, INITVAL_10 = 0, INITVAL_11 = 0,
    INITVAL_12 = 0, INITVAL_13 = 0, INITVAL_14 = 0, INITVAL_15 = 0, INITVAL_16 = 0, INITVAL_17 = 0,
    INITVAL_18 = 0, INITVAL_19 = 0, INITVAL_1A = 0, INITVAL_1B = 0, INITVAL_1C = 0, INITVAL_1D = 0,
    INITVAL_1E = 0, INITVAL_1F = 0, INITVAL_20 = 0, INITVAL_21 = 0, INITVAL_22 = 0, INITVAL_23 = 0,
    INITVAL_24 = 0, INITVAL_25 = 0, INITVAL_26 = 0, INITVAL_27 = 0, INITVAL_28 = 0, INITVAL_29 = 0,
    INITVAL_2A = 0, INITVAL_2B = 0, INITVAL_2C = 0, INITVAL_2D = 0, INITVAL_2E = 0, INITVAL_2F = 0,
    INITVAL_30 = 0, INITVAL_31 = 0, INITVAL_32 = 0, INITVAL_33 = 0, INITVAL_34 = 0, INITVAL_35 = 0,
    INITVAL_36 = 0, INITVAL_37 = 0, INITVAL_38 = 0, INITVAL_39 = 0, INITVAL_3A = 0, INITVAL_3B = 0,
    INITVAL_3C = 0, INITVAL_3D = 0, INITVAL_3E = 0, INITVAL_3F = 0;
  localparam [20479:0] INITIAL = {
    INITVAL_3F, INITVAL_3E, INITVAL_3D, INITVAL_3C, INITVAL_3B, INITVAL_3A, INITVAL_39, INITVAL_38, INITVAL_37,
    INITVAL_36, INITVAL_35, INITVAL_34, INITVAL_33, INITVAL_32, INITVAL_31, INITVAL_30, INITVAL_2F, INITVAL_2E,
    INITVAL_2D, INITVAL_2C, INITVAL_2B, INITVAL_2A, INITVAL_29, INITVAL_28, INITVAL_27, INITVAL_26, INITVAL_25,
    INITVAL_24, INITVAL_23, INITVAL_22, INITVAL_21, INITVAL_20, INITVAL_1F, INITVAL_1E, INITVAL_1D, INITVAL_1C,
    INITVAL_1B, INITVAL_1A, INITVAL_19, INITVAL_18, INITVAL_17, INITVAL_16, INITVAL_15, INITVAL_14, INITVAL_13,
    INITVAL_12, INITVAL_11, INITVAL_10, INITVAL_0F, INITVAL_0E, INITVAL_0D, INITVAL_0C, INITVAL_0B, INITVAL_0A,
    INITVAL_09, INITVAL_08, INITVAL_07, INITVAL_06, INITVAL_05, INITVAL_04, INITVAL_03, INITVAL_02, INITVAL_01,
    INITVAL_00};

  /* verilator lint_off WIDTH */  // texts of different lengths
  localparam
    INVERTED_A = CLKAMUX == "INV", INVERTED_B = CLKBMUX == "INV",
    REGISTERED_A = REGMODE_A == "OUTREG", REGISTERED_B = REGMODE_B == "OUTREG",
    THROUGH_A = WRITEMODE_A == "WRITETHROUGH", THROUGH_B = WRITEMODE_B == "WRITETHROUGH",
    BEFORE_A = WRITEMODE_A == "READBEFOREWRITE", BEFORE_B = WRITEMODE_B == "READBEFOREWRITE";

  function known(input integer width);
    known = width == 1 || width == 2 || width == 4 || width == 9 || width == 18;
  endfunction
  initial begin
    if (!(known(DATA_WIDTH_A) || DATA_WIDTH_A == 36) || !(known(DATA_WIDTH_B) || DATA_WIDTH_B == 36 && DATA_WIDTH_A == 36))
      $fatal(1, "%m: DP16KD: widths %0d and %0d do not go together", DATA_WIDTH_A, DATA_WIDTH_B);
    if (CSDECODE_A != "0b000" || CSDECODE_B != "0b000"
        || CEAMUX != "CEA" || OCEAMUX != "OCEA" || WEAMUX != "WEA" || RSTAMUX != "RSTA"
        || CEBMUX != "CEB" || OCEBMUX != "OCEB" || WEBMUX != "WEB" || RSTBMUX != "RSTB")
      $fatal(1, "%m: a mode of DP16KD that is not modelled");
    if (!(REGISTERED_A || REGMODE_A == "NOREG") || !(REGISTERED_B || REGMODE_B == "NOREG"))
      $fatal(1, "%m: DP16KD: no such REGMODE");
    if (!(BEFORE_A || THROUGH_A || WRITEMODE_A == "NORMAL") || !(BEFORE_B || THROUGH_B || WRITEMODE_B == "NORMAL"))
      $fatal(1, "%m: DP16KD: no such WRITEMODE");
  end
  /* verilator lint_on WIDTH */

  reg [8:0] bytes [0:2047];
  integer i;
  initial  // of 20 bits in INITVAL, 18 are memory
    for (i = 0; i < 1024; i = i + 1) {bytes[2 * i + 1], bytes[2 * i]} = INITIAL[20 * i +: 18];

  wire [13:0] address_a = {
    ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0};
  wire [13:0] address_b = {
    ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0};
  wire [17:0] data_a = {
    DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2,
    DIA1, DIA0};
  wire [17:0] data_b = {
    DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2,
    DIB1, DIB0};
  wire clock_a = INVERTED_A ? ~CLKA : CLKA, clock_b = INVERTED_B ? ~CLKB : CLKB;
  wire select_a = CEA & ({CSA2, CSA1, CSA0} === 3'b000), select_b = CEB & ({CSB2, CSB1, CSB0} === 3'b000);

  // Bytes of a word that a write changes.
  function [3:0] lanes(input integer width, input [13:0] address);
    lanes = width == 36 ? address[3:0] : width == 18 ? {2'b00, address[1:0]} : 4'b0001;
  endfunction

  // Number of a word's lowest byte.
  function [10:0] place(input integer width, input [13:0] address);
    place = width == 36 ? {address[13:5], 2'b00} : width == 18 ? {address[13:4], 1'b0} : address[13:3];
  endfunction

  wire write_a = select_a & WEA & |lanes(DATA_WIDTH_A, address_a);
  wire write_b = select_b & WEB & |lanes(DATA_WIDTH_B, address_b);
  wire [10:0] byte_a = place(DATA_WIDTH_A, address_a), byte_b = place(DATA_WIDTH_B, address_b);

  // The 36 bits from a byte on, narrow words in the lowest place.
  function [35:0] word(input integer width, input [13:0] address, input [10:0] at);
    case (width)
      36: word = {bytes[at + 3], bytes[at + 2], bytes[at + 1], bytes[at]};
      18: word = {18'b0, bytes[at + 1], bytes[at]};
      9: word = {27'b0, bytes[at]};
      4: word = {32'b0, bytes[at][4 * address[2] +: 4]};
      2: word = {34'b0, bytes[at][2 * address[2:1] +: 2]};
      default: word = {35'b0, bytes[at][{1'b0, address[2:0]}]};
    endcase
  endfunction

  // Does a write of the other port meet the word?
  function meets(input integer width, input [10:0] at, input integer other_width, input [10:0] other);
    meets = at < other + (other_width == 36 ? 4 : other_width == 18 ? 2 : 1)
      && other < at + (width == 36 ? 4 : width == 18 ? 2 : 1);
  endfunction

  // Takes effect behind every read of this clock edge.
  task write(input integer width, input [13:0] address, input [10:0] at, input [35:0] data);
    integer k;
    case (width)
      36, 18: for (k = 0; k < width / 9; k = k + 1) if (address[k]) bytes[at + k[10:0]] <= data[9 * k +: 9];
      9: bytes[at] <= data[8:0];
      4: bytes[at][4 * address[2] +: 4] <= data[3:0];
      2: bytes[at][2 * address[2:1] +: 2] <= data[1:0];
      default: bytes[at][{1'b0, address[2:0]}] <= data[0];
    endcase
  endtask

  // What a port sees while it writes: the old word with the written bytes in it.
  function [35:0] through(input integer width, input [13:0] address, input [35:0] old, input [35:0] data);
    integer k;
    begin
      through = width == 18 ? old : data;
      if (width == 18) for (k = 0; k < 2; k = k + 1) if (address[k]) through[9 * k +: 9] = data[9 * k +: 9];
    end
  endfunction

  reg [35:0] read_a, read_b, register_a, register_b;
  initial begin
    read_a = 0;
    read_b = 0;
    register_a = 0;
    register_b = 0;
  end
  always @(posedge clock_a) begin
    if (write_a) write(DATA_WIDTH_A, address_a, byte_a, {data_b, data_a});
    if (RSTA === 1'b1) read_a <= 0;
    else if (select_a && DATA_WIDTH_A != 36) begin
      if (write_b && meets(DATA_WIDTH_A, byte_a, DATA_WIDTH_B, byte_b)) read_a <= {36{1'bx}};
      else if (!write_a || BEFORE_A) read_a <= word(DATA_WIDTH_A, address_a, byte_a);
      else if (THROUGH_A)
        read_a <= through(DATA_WIDTH_A, address_a, word(DATA_WIDTH_A, address_a, byte_a), {18'b0, data_a});
    end
    if (RSTA === 1'b1) register_a <= 0;
    else if (OCEA) register_a <= read_a;
  end
  always @(posedge clock_b) begin
    if (write_b) write(DATA_WIDTH_B, address_b, byte_b, {18'b0, data_b});
    if (RSTB === 1'b1) read_b <= 0;
    else if (select_b) begin
      if (write_a && meets(DATA_WIDTH_B, byte_b, DATA_WIDTH_A, byte_a)) read_b <= {36{1'bx}};
      else if (!write_b || BEFORE_B) read_b <= word(DATA_WIDTH_B, address_b, byte_b);
      else if (THROUGH_B)
        read_b <= through(DATA_WIDTH_B, address_b, word(DATA_WIDTH_B, address_b, byte_b), {18'b0, data_b});
    end
    if (RSTB === 1'b1) register_b <= 0;
    else if (OCEB) register_b <= read_b;
  end

  wire [35:0] result_a = REGISTERED_A ? register_a : read_a;
  wire [35:0] result_b = REGISTERED_B ? register_b : read_b;
  assign {
    DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2,
    DOA1, DOA0} = DATA_WIDTH_B == 36 ? result_b[17:0] : result_a[17:0];
  assign {
    DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2,
    DOB1, DOB0} = DATA_WIDTH_B == 36 ? result_b[35:18] : result_b[17:0];

  // The mode alone is not fatal: yosys may choose either one for a memory that is never reset.  The clocks are for a
  // reset that is tied to 1, which has no edge.
  generate
    if (RESETMODE != "SYNC") begin : asynchronous
      always @(posedge clock_a or posedge clock_b or posedge RSTA or posedge RSTB)
        if (RSTA === 1'b1 || RSTB === 1'b1) $fatal(1, "%m: an asynchronous reset of DP16KD is not modelled");
    end
  endgenerate
endmodule
/* verilator lint_restore */
