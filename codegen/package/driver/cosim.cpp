/** @file cosim.cpp
 *  Co-simulation: the C driver opens and loads the Verilated core, recorded frames go through it, and every word of its
 *  results is compared.  In the package's folder, with Verilator 5:
 *
 *  verilator --cc --exe --build -O3 -CFLAGS "-I../driver -I../registers" -y testbench --top-module NAME_axi
 *            NAME_axi.v NAME.v driver/cosim.cpp driver/tfra_driver.c driver/tfra_frame.c && obj_dir/VNAME_axi
 */
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "VNAME_axi.h"
#include "verilated.h"

#include "NAME_config.h"
#include "NAME_coefficients.h"
#include "NAME_recorded.h"
#include "show.h"

namespace {

const int PATIENCE = 10000000; /**< Cycles, or reads of a register. */
VNAME_axi core;

void cycle(int count = 1)
{
    while (count--) {
        core.aclk = 1;
        core.eval();
        core.aclk = 0;
        core.eval();
    }
}

/** Registers, as the driver's callbacks: one access at a time. */
int read32(void *, uint32_t address, uint32_t *word)
{
    core.s_axi_araddr = address;
    core.s_axi_arvalid = core.s_axi_rready = 1;
    for (int cycles = 0; cycles < PATIENCE; cycles++) {
        const bool requested = core.s_axi_arready, answered = core.s_axi_rvalid;
        if (answered)
            *word = core.s_axi_rdata;
        const int response = core.s_axi_rresp;
        cycle();
        if (requested)
            core.s_axi_arvalid = 0;
        if (answered) {
            core.s_axi_rready = 0;
            return response;
        }
    }
    return 1;
}

int write32(void *, uint32_t address, uint32_t word)
{
    core.s_axi_awaddr = address;
    core.s_axi_wdata = word;
    core.s_axi_wstrb = 15;
    core.s_axi_awvalid = core.s_axi_wvalid = core.s_axi_bready = 1;
    for (int cycles = 0; cycles < PATIENCE; cycles++) {
        const bool addressed = core.s_axi_awready, taken = core.s_axi_wready, answered = core.s_axi_bvalid;
        const int response = core.s_axi_bresp;
        cycle();
        if (addressed)
            core.s_axi_awvalid = 0;
        if (taken)
            core.s_axi_wvalid = 0;
        if (answered) {
            core.s_axi_bready = 0;
            return response;
        }
    }
    return 1;
}

/** The beats of the output frame for `codes`; both sides pause at random. */
std::vector<uint32_t> estimate(const uint16_t *codes)
{
    std::vector<uint32_t> beats;
    size_t taxel = 0;
    for (int cycles = 0; cycles < PATIENCE; cycles++) {
        uint64_t words = 0;
        for (size_t slot = 0; slot < NAME_TAXELS_PER_BEAT && taxel + slot < NAME_TAXELS; slot++)
            words |= uint64_t(codes[taxel + slot]) << 16 * slot;
        core.s_axis_tdata = words;
        core.s_axis_tlast = taxel + NAME_TAXELS_PER_BEAT >= NAME_TAXELS;
        core.s_axis_tvalid = taxel < NAME_TAXELS && (core.s_axis_tvalid || std::rand() % 4);
        core.m_axis_tready = std::rand() % 4 != 0;
        const bool sent = core.s_axis_tvalid && core.s_axis_tready, came = core.m_axis_tvalid && core.m_axis_tready;
        const bool last = core.m_axis_tlast;
        if (came)
            beats.push_back(core.m_axis_tdata);
        cycle();
        if (sent) {
            taxel += NAME_TAXELS_PER_BEAT;
            core.s_axis_tvalid = 0;
        }
        if (came && last)
            break;
    }
    core.m_axis_tready = 0;
    return beats;
}

void check(const char *what, tfra_error_t error)
{
    if (error != TFRA_OK) {
        std::printf("FAILED: %s: error %d\n", what, int(error));
        std::exit(1);
    }
}

} // namespace

int main()
{
    const tfra_bus_t bus = {read32, write32, nullptr, PATIENCE};
    const tfra_config_t *const config = &NAME_config;
    tfra_device_t device;
    size_t words = 0, wrong = 0;

    core.aresetn = 0;
    cycle(8);
    core.aresetn = 1;
    cycle(4);
    check("open", tfra_open(&device, &bus, config));
    check("load", tfra_load(&device, NAME_coefficients, config->load_words));
    check("start", tfra_start(&device));
    for (const auto &recorded : NAME_recorded) {
        const std::vector<uint32_t> beats = estimate(recorded.codes);
        check("frame", show(config, beats.data(), beats.size()));
        for (size_t word = 0; word < recorded.count; word++, words++) {
            const size_t beat = TFRA_HEADER_BEATS + word;
            wrong += beat >= beats.size() || beats[beat] != uint32_t(recorded.words[word]);
        }
    }
    check("stop", tfra_stop(&device));
    std::printf("%s: %zu words compared, %zu differ\n", wrong ? "FAILED" : "PASSED", words, wrong);
    return wrong != 0;
}
