// SPDX-License-Identifier: MIT
// karst as a library: terrain in somebody else's picture. Needs neither GLM nor a GL header, throws nothing,
// and takes no memory after World::create() and Renderer::create() but what was planned.
//
//   Plan plan;  plan.needs.views = 2;  plan.needs.queries = 1;  plan.needs.max_gpu_bytes = 24 << 20;
//   make_plan(file, plan);                                // what it takes; nothing is taken yet
//   memory = aligned_alloc(kMemoryAlignment, plan.cpu_bytes);
//   World::create(plan, file, {memory, plan.cpu_bytes}, world);           // any thread, no GL
//   Renderer::create(*world, loader, {}, renderer);       // the context is current, here and below
//   each frame:
//     FrameResult result;
//     renderer->begin_frame({.views = views, .sun = sun, .work_ms = 3}, result);
//     glBindFramebuffer(GL_FRAMEBUFFER, yours);  glClear(GL_DEPTH_BUFFER_BIT);
//     renderer->draw(0, {.viewport = {0, 0, width, height}});
//     ... your own things, in the same depth buffer ...
//     renderer->end_frame();
//   renderer->destroy();  world->destroy();  free(memory);
//
// Lengths are metres in the simulator's frame (Placement). Every function that can fail returns a Status,
// which says what, which field or limit, and the value that was needed.
//
// Threads. make_plan(), read_world_info() and World::create(): any. A Renderer: its context's thread. A
// Query: one thread at a time; different ones beside each other, beside the Renderer, and beside take_query()
// and release(), which any thread may call. World's other functions are const and may be called from
// anywhere.
#pragma once

#include "karst/edit.h"
#include "karst/plan.h"
#include "karst/query.h"
#include "karst/renderer.h"
#include "karst/status.h"
#include "karst/types.h"
#include "karst/version.h"
#include "karst/world.h"

namespace karst {

// Of the library that was linked; kApiVersion is that of these headers. It grows when a program has to
// change.
inline constexpr std::uint32_t kApiVersion = 1;
KARST_API std::uint32_t api_version() noexcept;

}  // namespace karst
