// A core's registers with a small model of the rest: it plays prepared results instead of computing them, and has
// no front end.  Wires REGISTER_field are declared before this text; those that nothing here drives are 0.

wire reset = !aresetn || CONTROL_soft_reset;
wire arrives = s_axis_tvalid && s_axis_tready;
wire done = m_axis_tvalid && m_axis_tready && m_axis_tlast;
reg [15:0] place;
reg [6:0] taring;
reg emitting;

function [31:0] crc32(input [31:0] crc, input [31:0] word);
  integer place;
  begin
    crc32 = ~crc;
    for (place = 0; place < 32; place = place + 1)
      crc32 = {1'b0, crc32[31:1]} ^ (crc32[0] ^ word[place] ? 32'hEDB88320 : 32'h0);
    crc32 = ~crc32;
  end
endfunction

// Coefficients: ready pauses after each of them.
reg [31:0] load_crc, load_count;
reg [2:0] pause;
reg was_loaded;
wire taken = LOAD_DATA_word_written && LOAD_STATUS_ready;
assign LOAD_STATUS_ready = load_count != LOAD_WORDS && pause == 0;
assign LOAD_COUNT_words_up = taken;
assign LOAD_CRC_crc = load_crc;
assign LOAD_STATUS_match = load_crc == LOAD_CHECKSUM_crc;
assign STATUS_loaded = load_count == LOAD_WORDS;
assign INTERRUPT_STATUS_loaded_set = STATUS_loaded && !was_loaded && LOAD_WORDS != 0;
assign ERRORS_load_checksum_set = INTERRUPT_STATUS_loaded_set && !LOAD_STATUS_match;
always @(posedge aclk) begin
  pause <= taken ? 7 : pause - (pause != 0);
  was_loaded <= STATUS_loaded;
  if (taken) begin
    load_count <= load_count + 1;
    load_crc <= crc32(load_crc, LOAD_DATA_word);
  end
  if (reset) begin
    load_count <= 0;
    load_crc <= 0;
    pause <= 7;
    was_loaded <= LOAD_WORDS == 0;
  end
end

// Tables.
reg [17:0] offsets [0:TAXELS-1];
reg [16:0] gains [0:TAXELS-1];
reg [15:0] index;
reg [1:0] kind;
reg [31:0] table_crc;
integer first;
initial for (first = 0; first < TAXELS; first = first + 1) begin
  offsets[first] = 0;
  gains[first] = 32768;
end
assign CALIBRATION_VALUE_word = kind == 0 ? {{14{offsets[index][17]}}, offsets[index]} : kind == 1 ? gains[index] : 0;
assign CALIBRATION_CRC_crc = table_crc;
always @(posedge aclk) begin
  if (CALIBRATION_PLACE_index_written) begin
    index <= CALIBRATION_PLACE_index;
    kind <= CALIBRATION_PLACE_kind;
    table_crc <= 0;
  end
  if (CALIBRATION_DATA_word_written) begin
    index <= index + 1;
    table_crc <= crc32(table_crc, CALIBRATION_DATA_word);
    if (kind == 1) gains[index] <= CALIBRATION_DATA_word;
    if (kind == 0) offsets[index] <= CALIBRATION_DATA_word;
  end
  if (arrives && taring != 0) offsets[place] <= $signed(s_axis_tdata) <<< (17 - FRONT_END_word_bits);
end

// Frames in.
reg [15:0] arrived, number, user;
reg compared, simulated, gap;
wire ends = arrives && s_axis_tlast;
wire good = ends && place == TAXELS - 1;
assign STATUS_running = CONTROL_run || place != 0;
assign STATUS_busy = emitting;
assign STATUS_taring = taring != 0;
assign s_axis_tready = STATUS_running && !emitting;
assign FRAMES_IN_count_up = good;
assign FRAMES_DROPPED_count_up = ends && !good;
assign ERRORS_short_frame_set = ends && place < TAXELS - 1;
assign ERRORS_long_frame_set = ends && place == TAXELS;
assign ERRORS_sequence_gap_set = ends && compared && s_axis_tuser != number;
assign ERRORS_simulated_set = CONTROL_simulate_error;
assign INTERRUPT_STATUS_error_set = ERRORS_short_frame_set || ERRORS_long_frame_set || ERRORS_sequence_gap_set
  || ERRORS_simulated_set || ERRORS_load_checksum_set || ERRORS_stale_set;
always @(posedge aclk) begin
  if (arrives && place != TAXELS) place <= place + 1;
  if (CONTROL_simulate_error) simulated <= 1;
  if (ERRORS_sequence_gap_set) gap <= 1;
  if (CONTROL_tare) taring <= 1 << TARE_log2_frames;
  if (ends) begin
    place <= 0;
    arrived <= arrived + 1;
    user <= s_axis_tuser;
    number <= s_axis_tuser + 1;
    compared <= CONTROL_check_sequence;
    if (good && taring != 0) taring <= taring - 1;
  end
  if (!CONTROL_check_sequence) compared <= 0;
  if (done) {simulated, gap} <= 0;
  if (reset) begin
    place <= 0;
    arrived <= 0;
    taring <= 0;
    {compared, simulated, gap} <= 0;
  end
end

// Stale: the clock cycles since the last frame.
reg [31:0] idle;
assign ERRORS_stale_set = FRAME_TIMEOUT_cycles != 0 && idle == FRAME_TIMEOUT_cycles;
always @(posedge aclk) idle <= reset || ends || !CONTROL_run || ERRORS_stale_set ? 0 : idle + 1;

// Frames out: prepared ones in their order.
reg [31:0] results [0:FRAMES*WORDS-1];
initial $readmemh("results.hex", results);
reg [15:0] played, beat, cycles;
reg forces;
wire [15:0] word = beat - 2 + (!forces && beat >= FORCES + 2 ? 3 * TAXELS : 0);
wire [31:0] faults = simulated << 7 | gap << 5;
assign m_axis_tvalid = emitting;
assign m_axis_tuser = 0;
assign m_axis_tdata = beat == 0 ? {user, arrived - 16'd1} : beat == 1 ? 32'h01000000 | faults
  : results[played * WORDS + word];
assign m_axis_tlast = beat > 1 && word == WORDS - 1;
assign FRAMES_OUT_count_up = done;
assign INTERRUPT_STATUS_frame_set = done;
assign FRAME_CYCLES_cycles = cycles;
assign FRAME_CYCLES_cycles_store = done;
always @(posedge aclk) begin
  cycles <= arrives && place == 0 ? 0 : cycles + 1;
  if (good && taring == 0) begin
    emitting <= 1;
    beat <= 0;
    forces <= CONTROL_taxel_forces;
  end
  if (m_axis_tvalid && m_axis_tready) beat <= beat + 1;
  if (done) begin
    emitting <= 0;
    played <= played + 1;
  end
  if (reset) begin
    emitting <= 0;
    played <= 0;
  end
end
