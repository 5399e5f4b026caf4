/** @file tfra_units.h
 *  Words of an output frame in newton and degrees, as double; needs no mathematical library.
 */
#ifndef TFRA_UNITS_H
#define TFRA_UNITS_H

#include "tfra_driver.h"

/** A force in N: `word` is one of `frame`'s and belongs to `field`. */
static inline double tfra_newton(const tfra_field_t *field, const tfra_frame_t *frame, int32_t word)
{
    return word * field->lsb / (double)(UINT32_C(1) << frame->exponent);
}

/** Component 0 to 2 (x, y, z) of the resultant in N. */
static inline double tfra_resultant(const tfra_config_t *config, const tfra_frame_t *frame, uint32_t axis)
{
    return tfra_newton(&config->resultant, frame, frame->resultant[axis]);
}

/** Component of the force at a taxel, of a skin at one of the window, in N; only of a frame with forces. */
static inline double tfra_force(const tfra_config_t *config, const tfra_frame_t *frame, uint32_t axis, uint32_t taxel)
{
    return tfra_newton(&config->forces, frame, frame->forces[axis * (config->forces.count / 3u) + taxel]);
}

/** The learned estimator's uncertainty of the resultant in N. */
static inline double tfra_uncertainty(const tfra_config_t *config, const tfra_frame_t *frame)
{
    return tfra_newton(&config->uncertainty, frame, frame->uncertainty);
}

/** Direction of the tangential force in degrees, 0 to 360. */
static inline double tfra_phi(const tfra_config_t *config, const tfra_frame_t *frame)
{
    return frame->phi * config->phi.lsb;
}

/** Coefficient of friction. */
static inline double tfra_mu(const tfra_config_t *config, const tfra_frame_t *frame)
{
    return frame->mu * config->mu.lsb;
}

static inline double tfra_mu_x(const tfra_config_t *config, const tfra_frame_t *frame)
{
    return frame->mu_x * config->mu_x.lsb;
}

static inline double tfra_mu_y(const tfra_config_t *config, const tfra_frame_t *frame)
{
    return frame->mu_y * config->mu_y.lsb;
}

/** Where a contact on a skin is along the columns, in m from the first taxel. */
static inline double tfra_x(const tfra_config_t *config, const tfra_contact_t *contact)
{
    return contact->column * config->x_lsb;
}

static inline double tfra_y(const tfra_config_t *config, const tfra_contact_t *contact)
{
    return contact->row * config->y_lsb;
}

#endif
