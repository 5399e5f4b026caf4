// Start of a Cortex-M7 in QEMU (mps2-an500): vectors, a painted stack, and main's result by semihosting.
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

extern uint32_t stack_top, stack_bottom, data_start, data_end, data_load, bss_start, bss_end;
extern void initialise_monitor_handles(void);
extern int main(void);

void reset(void);
void _fini(void);
void _fini(void) {} // exit() calls it
static void fault(void) { exit(99); }

__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    &stack_top, (const void *)reset, (const void *)fault, (const void *)fault, (const void *)fault, (const void *)fault,
};

void reset(void)
{
    memcpy(&data_start, &data_load, (size_t)((char *)&data_end - (char *)&data_start));
    memset(&bss_start, 0, (size_t)((char *)&bss_end - (char *)&bss_start));
    initialise_monitor_handles();
    exit(main());
}
