// Loads coefficients, sends codes and prints result words, "word last", each stream at random moments.
`timescale 1ns / 1ns
module bench;
    reg clk = 0, rst = 1;
    reg [`COEFFICIENT - 1:0] load [0:`LOADS - 1];
    reg [`ADC - 1:0] taxel [0:`TAXELS - 1];
    integer loads = 0, taxels = 0, words = 0, seed = 1;
    reg load_valid = 0, taxel_valid = 0, result_ready = 0;
    wire load_ready, taxel_ready, result_valid;
    wire [`WORD:0] result;  // last, word

    serial dut (
        .clk(clk), .rst(rst),
        .load__payload(load[loads]), .load__valid(load_valid), .load__ready(load_ready),
        .taxel__payload(taxel[taxels]), .taxel__valid(taxel_valid), .taxel__ready(taxel_ready),
        .result__payload(result), .result__valid(result_valid), .result__ready(result_ready)
    );

    always #5 clk = !clk;
    initial begin
        $readmemh("load.hex", load);
        $readmemh("taxel.hex", taxel);
        #20 rst = 0;
        #20_000_000 $display("timeout");
        $finish;
    end
    always @(posedge clk) if (!rst) begin
        if (load_valid && load_ready) loads <= loads + 1;
        if (taxel_valid && taxel_ready) taxels <= taxels + 1;
        if (result_valid && result_ready) begin
            $display("%0d %b", $signed(result[`WORD - 1:0]), result[`WORD]);
            words <= words + 1;
            if (words + 1 == `WORDS) $finish;
        end
    end
    always @(negedge clk) begin
        // valid stays until the transfer; the counts are new here already
        load_valid <= loads < `LOADS && (load_valid && !load_ready || $random(seed) % 4 != 0);
        taxel_valid <= taxels < `TAXELS && (taxel_valid && !taxel_ready || $random(seed) % 3 == 0);
        result_ready <= $random(seed) % 3 == 0;
    end
endmodule
