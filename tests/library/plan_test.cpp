// SPDX-License-Identifier: MIT
// Plans and worlds through the public headers: what is refused, what is enough, and files that are broken.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "tests/library/host.h"
#include "tests/support/hilly_world.h"
#include "tests/support/world_damage.h"

namespace karst {
namespace {

using test::MemoryFile;

std::string refused_field(const Status& status) {
  EXPECT_EQ(status.code(), StatusCode::invalid_argument) << status.what();
  return status.field();
}

class Plans : public testing::Test {
 protected:
  Status plan_with(const std::function<void(Plan&)>& change) {
    plan = Plan();
    change(plan);
    return make_plan(source, plan);
  }
  // Refused with and without a file, by name.
  void refuses(const char* field, const std::function<void(Needs&)>& change) {
    EXPECT_EQ(refused_field(plan_with([&](Plan& p) { change(p.needs); })), field);
    Plan without;
    change(without.needs);
    EXPECT_EQ(refused_field(make_plan(without)), field) << "without a file";
  }
  void takes(const std::function<void(Needs&)>& change) {
    const Status status = plan_with([&](Plan& p) {
      p.needs.max_gpu_bytes = p.needs.max_cpu_bytes = std::uint64_t{1} << 40;
      change(p.needs);
    });
    EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  }

  MemoryFile file{test::cave_world_file()};
  Source source = file.source();
  Plan plan;
};

TEST_F(Plans, EachWrongNeedIsNamed) {
  constexpr std::uint32_t kHuge = std::numeric_limits<std::uint32_t>::max();
  const struct {
    const char* name;
    std::uint32_t Needs::*field;
    std::vector<std::uint32_t> wrong, right;
  } kFields[] = {
      {"views", &Needs::views, {0, kMostViews + 1, kHuge}, {1, kMostViews}},
      {"level", &Needs::level, {0, kFinestLevel + 1, kHuge}, {1, kFinestLevel}},
      {"queries", &Needs::queries, {kMostQueries + 1, kHuge}, {0, kMostQueries}},
      {"query_level", &Needs::query_level, {0, kFinestLevel + 1, kHuge}, {1, kFinestLevel}},
      {"query_patches", &Needs::query_patches, {0, 15, 65'537, kHuge}, {16, 65'536}},
      {"query_tiles", &Needs::query_tiles, {0, 21, 65'537, kHuge}, {22, 65'536}},
      {"shadow_maps", &Needs::shadow_maps, {kMostShadowMaps + 1, kHuge}, {0, kMostShadowMaps}},
      {"shadow_size",
       &Needs::shadow_size,
       {0, 496, 520, 2064, kHuge, 1u << 16},
       {kLeastShadowSize, kLeastShadowSize + kShadowSizeStep, kMostShadowSize}},
  };
  for (const auto& field : kFields) {
    for (const std::uint32_t value : field.wrong) {
      SCOPED_TRACE(std::string(field.name) + " " + std::to_string(value));
      refuses(field.name, [&](Needs& needs) { needs.*field.field = value; });
    }
    for (const std::uint32_t value : field.right) {
      SCOPED_TRACE(std::string(field.name) + " " + std::to_string(value));
      takes([&](Needs& needs) { needs.*field.field = value; });
    }
  }
  for (const double reach : {-1.0, std::nan(""), double{INFINITY}}) {
    refuses("shadow_reach_m", [&](Needs& needs) { needs.shadow_reach_m = reach; });
  }
  refuses("drape_height", [](Needs& needs) { needs.drape_width = 8; });
  refuses("drape_width", [](Needs& needs) { needs.drape_height = 8; });
  refuses("drape_width", [](Needs& needs) {
    needs.drape_width = kMostPictureSide + 1;
    needs.drape_height = 8;
  });
  refuses("drape_height", [](Needs& needs) {
    needs.drape_width = 8;
    needs.drape_height = kMostPictureSide + 1;
  });
  takes([](Needs& needs) { needs.drape_width = needs.drape_height = kMostPictureSide; });
}

TEST_F(Plans, EachWrongPlacementIsNamed) {
  const auto refuses_placement = [&](const char* field, const Placement& placement) {
    EXPECT_EQ(refused_field(plan_with([&](Plan& p) { p.placement = placement; })), field);
    Plan without;
    without.placement = placement;
    EXPECT_EQ(refused_field(make_plan(without)), field) << "without a file";
  };
  refuses_placement("axes", {static_cast<Axes>(3), {}, 0});
  for (const double wrong : {1.001e12, -1.001e12, std::nan(""), double{INFINITY}}) {
    refuses_placement("origin", {Axes::east_north_up, {wrong, 0, 0}, 0});
    refuses_placement("origin", {Axes::east_north_up, {0, wrong, 0}, 0});
    refuses_placement("origin", {Axes::east_north_up, {0, 0, wrong}, 0});
  }
  for (const double wrong : {360.5, -360.5, std::nan(""), double{INFINITY}}) {
    refuses_placement("turn_deg", {Axes::east_north_up, {}, wrong});
  }
  EXPECT_TRUE(plan_with([](Plan& p) { p.placement = {Axes::north_east_down, {1e12, -1e12, 0}, -360}; }).ok());
}

TEST_F(Plans, TheBytesThatAreNamedAreEnough) {
  ASSERT_TRUE(plan_with([](Plan&) {}).ok());
  EXPECT_TRUE(plan.holds_all_heights);
  const std::uint64_t plenty = plan.cpu_bytes;
  const auto take_room = [&](std::uint64_t Needs::*limit, const char* name, std::uint64_t start) {
    const Status less = plan_with([&](Plan& p) { p.needs.*limit = start; });
    ASSERT_EQ(less.code(), StatusCode::limit_reached);
    EXPECT_STREQ(less.field(), name);
    ASSERT_GT(less.value(), start);
    const Status enough = plan_with([&](Plan& p) { p.needs.*limit = less.value(); });
    EXPECT_TRUE(enough.ok()) << enough.what() << " " << enough.value();
    const Status one_less = plan_with([&](Plan& p) { p.needs.*limit = less.value() - 1; });
    EXPECT_EQ(one_less.code(), StatusCode::limit_reached);
    EXPECT_EQ(one_less.value(), less.value());
  };
  take_room(&Needs::max_cpu_bytes, "max_cpu_bytes", 0);
  take_room(&Needs::max_gpu_bytes, "max_gpu_bytes", 0);
  // Heights give way first: a plan with room for all but one byte holds fewer of them.
  ASSERT_TRUE(plan_with([&](Plan& p) { p.needs.max_cpu_bytes = plenty - 1; }).ok());
  EXPECT_FALSE(plan.holds_all_heights);
  EXPECT_LT(plan.cpu_bytes, plenty);
  ASSERT_TRUE(plan_with([&](Plan& p) { p.needs.max_cpu_bytes = plenty; }).ok());
  EXPECT_TRUE(plan.holds_all_heights);
}

TEST_F(Plans, TermsSumUpToTheTotals) {
  const auto check = [](const Plan& p) {
    std::uint64_t cpu = 0;
    std::uint64_t gpu = 0;
    ASSERT_LE(p.term_count, std::size(p.terms));
    for (std::uint32_t n = 0; n < p.term_count; ++n) {
      EXPECT_GT(std::strlen(p.terms[n].name), 0u);
      (p.terms[n].gpu ? gpu : cpu) += p.terms[n].bytes;
    }
    EXPECT_EQ(cpu, p.cpu_bytes);
    EXPECT_EQ(gpu, p.gpu_bytes);
    EXPECT_GT(p.limit_count, 5u);
    for (std::uint32_t n = 0; n < p.limit_count; ++n) {
      EXPECT_GE(p.limits[n].value, p.limits[n].least) << p.limits[n].name;
      EXPECT_LE(p.limits[n].value, p.limits[n].most) << p.limits[n].name;
    }
  };
  for (const std::uint32_t queries : {0u, 1u, 7u, 64u}) {
    takes([&](Needs& needs) {
      needs.queries = queries;
      needs.views = 1 + queries % 8;
      needs.drape_width = needs.drape_height = queries == 7 ? 77 : 0;
    });
    check(plan);
    EXPECT_NE(plan.head.hash, 0u);
  }
  Plan without;
  without.needs.max_gpu_bytes = without.needs.max_cpu_bytes = std::uint64_t{1} << 40;
  ASSERT_TRUE(make_plan(without).ok());
  check(without);
  EXPECT_EQ(without.head.hash, 0u);
}

TEST_F(Plans, VerticesOfAnySizeGiveAPlanOrAreNamed) {
  for (const std::uint64_t bytes : {std::uint64_t{1}, std::uint64_t{4096}, ~std::uint64_t{0}}) {
    const Status status = plan_with([&](Plan& p) { p.needs.vertex_bytes = bytes; });
    if (!status.ok()) {
      EXPECT_EQ(status.code(), StatusCode::limit_reached) << status.what() << " " << status.field();
      EXPECT_STREQ(status.field(), "vertex_bytes");
      EXPECT_TRUE(plan_with([&](Plan& p) { p.needs.vertex_bytes = status.value(); }).ok());
    }
  }
}

class Worlds : public Plans {
 protected:
  void SetUp() override {
    ASSERT_TRUE(plan_with([](Plan& p) { p.needs.queries = 1; }).ok());
    memory_ = std::make_unique<test::AlignedBytes>(plan.cpu_bytes + kMemoryAlignment);
  }
  std::span<std::byte> memory() const { return memory_->bytes().first(plan.cpu_bytes); }
  // Makes a world of a file; where that works it is used and destroyed.
  Status try_file(const Source& from, const Plan& with) {
    World* world = nullptr;
    const Status status = World::create(with, from, memory(), world);
    EXPECT_EQ(status.ok(), world != nullptr);
    if (world == nullptr) return status;
    Query* query = nullptr;
    EXPECT_TRUE(world->take_query(query).ok());
    Hit hit;
    const WorldInfo& info = world->info();
    query->ray(world->from_world({info.low_m.x, info.high_m.y + 1, info.low_m.z}),
               world->from_world({info.high_m.x, info.low_m.y - 1, info.high_m.z}), Wait::for_file, hit);
    static_cast<void>(query->prepare(hit.place, 5));
    world->release(query);
    world->destroy();
    return status;
  }
  // The same memory still takes a whole world.
  void memory_is_usable() {
    const Status status = try_file(source, plan);
    EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  }

  std::unique_ptr<test::AlignedBytes> memory_;
};

TEST_F(Worlds, APlanForAnotherFileIsRefused) {
  MemoryFile other(test::hilly_world().file());
  EXPECT_EQ(refused_field(try_file(other.source(), plan)), "plan");
  // As large as the other in all parts, but elsewhere.
  std::vector<std::byte> bytes = test::cave_world_file();
  core::store_at(bytes, core::world_offsets::kOrigin, 1234.5);
  core::fix_checksums(bytes);
  MemoryFile elsewhere(std::move(bytes));
  Plan own;
  own.needs = plan.needs;
  ASSERT_TRUE(make_plan(elsewhere.source(), own).ok());
  EXPECT_EQ(own.cpu_bytes, plan.cpu_bytes);
  EXPECT_TRUE(try_file(elsewhere.source(), own).ok());
  EXPECT_EQ(refused_field(try_file(elsewhere.source(), plan)), "plan");
  Plan without;
  ASSERT_TRUE(make_plan(without).ok());
  without.cpu_bytes = plan.cpu_bytes;
  EXPECT_EQ(refused_field(try_file(source, without)), "plan");
  EXPECT_EQ(refused_field(try_file(source, Plan())), "plan");
  memory_is_usable();
}

// Of what make_plan() has read nothing but the header's checksum is asked for again, so a head that somebody
// changes in between is not seen: the world is the one that was planned.
TEST_F(Worlds, TheHeadIsReadOnce) {
  std::vector<std::byte> bytes = test::cave_world_file();
  const auto sections = core::load_at<std::uint32_t>(bytes, core::world_offsets::kSections);
  const std::size_t head_end = core::world_offsets::kTable + sections * core::world_offsets::kEntry;
  struct Watched {
    std::vector<std::byte>* bytes;
    std::size_t head_end;
    std::uint64_t head_bytes = 0;  // read of the head
  } watched{&bytes, head_end};
  const Source from{bytes.size(),
                    [](void* user, std::uint64_t offset, std::byte* out, std::size_t count) {
                      auto* const w = static_cast<Watched*>(user);
                      std::copy_n(w->bytes->begin() + static_cast<std::ptrdiff_t>(offset), count, out);
                      if (offset < w->head_end) w->head_bytes += std::min(count, w->head_end - offset);
                      return true;
                    },
                    &watched};
  Head head;
  ASSERT_TRUE(read_head(from, head).ok());
  const WorldInfo info = info_of(head);
  EXPECT_GT(info.patches, 0u);
  const std::uint64_t once = watched.head_bytes;
  EXPECT_EQ(once, head_end);
  Plan own;
  own.needs = plan.needs;
  ASSERT_TRUE(make_plan(head, own).ok());
  own.needs.max_cpu_bytes = own.cpu_bytes;
  ASSERT_TRUE(make_plan(head, own).ok());
  EXPECT_EQ(watched.head_bytes, once);
  // More patches, a coarser level, another table: none of it is looked at.
  for (const std::size_t at : {core::world_offsets::kPatches, core::world_offsets::kLevel,
                               core::world_offsets::kTable + core::world_offsets::kEntryOffset})
    bytes[at] ^= std::byte{0x7f};
  World* world = nullptr;
  test::AlignedBytes room(own.cpu_bytes);
  const Status status = World::create(own, from, room.bytes(), world);
  ASSERT_TRUE(status.ok()) << status.what() << " " << status.field();
  EXPECT_EQ(world->info().patches, info.patches);
  world->destroy();
  EXPECT_EQ(watched.head_bytes, once + 4) << "its checksum, to tell files apart";
  EXPECT_EQ(make_plan(Head(), own).code(), StatusCode::invalid_argument);
}

TEST_F(Worlds, APlanThatWasChangedIsRefused) {
  Plan changed = plan;
  changed.needs.queries = 2;
  EXPECT_EQ(refused_field(try_file(source, changed)), "plan");
  changed = plan;
  changed.needs.shadow_size = 2048;  // GPU memory alone
  EXPECT_EQ(refused_field(try_file(source, changed)), "plan");
  changed = plan;
  changed.cpu_bytes -= kMemoryAlignment;
  EXPECT_EQ(refused_field(try_file(source, changed)), "plan");
  changed = plan;
  changed.needs.views = 0;
  EXPECT_EQ(refused_field(try_file(source, changed)), "views");
  changed = plan;
  changed.placement.turn_deg = 1000;
  EXPECT_EQ(refused_field(try_file(source, changed)), "turn_deg");
  memory_is_usable();
}

TEST_F(Worlds, MemoryThatDoesNotFitIsRefused) {
  World* world = nullptr;
  const Status small = World::create(plan, source, memory().first(plan.cpu_bytes - 1), world);
  EXPECT_EQ(small.code(), StatusCode::limit_reached);
  EXPECT_STREQ(small.field(), "memory");
  EXPECT_EQ(small.value(), plan.cpu_bytes);
  EXPECT_EQ(world, nullptr);
  const std::uint64_t reads = file.reads();
  const Status none = World::create(plan, source, {}, world);
  EXPECT_STREQ(none.field(), "memory");
  for (const std::size_t off : {std::size_t{1}, std::size_t{8}, std::size_t{32}}) {
    const Status crooked =
        World::create(plan, source, memory_->bytes().subspan(off).first(plan.cpu_bytes), world);
    EXPECT_EQ(crooked.code(), StatusCode::invalid_argument);
    EXPECT_STREQ(crooked.field(), "memory");
    EXPECT_EQ(world, nullptr);
  }
  EXPECT_EQ(file.reads(), reads) << "refused before the file is read";
  memory_is_usable();
}

TEST_F(Worlds, NothingIsWrittenBesideTheMemory) {
  const std::span<std::byte> beyond = memory_->bytes().subspan(plan.cpu_bytes);
  std::fill(beyond.begin(), beyond.end(), std::byte{0xa5});
  memory_is_usable();
  for (const std::byte b : beyond) EXPECT_EQ(b, std::byte{0xa5});
}

TEST_F(Worlds, CutFilesAreRefused) {
  const std::vector<std::byte> whole = test::cave_world_file();
  std::vector<std::size_t> sizes;
  for (std::size_t n = 0; n < 700; n += 13) sizes.push_back(n);
  for (std::size_t n = 1; n < 40; ++n) sizes.push_back(whole.size() * n / 40);
  sizes.push_back(whole.size() - 1);
  for (const std::size_t size : sizes) {
    MemoryFile cut(std::vector<std::byte>(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    WorldInfo info;
    Plan other;
    EXPECT_FALSE(make_plan(cut.source(), other).ok()) << size;
    EXPECT_FALSE(read_world_info(cut.source(), info).ok()) << size;
    EXPECT_FALSE(check_world(cut.source(), info).ok()) << size;
    EXPECT_FALSE(try_file(cut.source(), plan).ok()) << size;
  }
  memory_is_usable();
}

TEST_F(Worlds, DamagedFilesAreRefusedOrHarmless) {
  const std::vector<std::byte> whole = test::cave_world_file();
  test::Random random{7};
  int refused = 0;
  for (int n = 0; n < 150; ++n) {
    std::vector<std::byte> bytes = whole;
    // Half of them in the head; half of them with checksums that fit.
    const std::size_t end = n % 2 == 0 ? std::min<std::size_t>(bytes.size(), 600) : bytes.size();
    for (int k = random.below(4); k >= 0; --k) {
      bytes[static_cast<std::size_t>(random.below(static_cast<int>(end)))] ^=
          static_cast<std::byte>(1 + random.below(255));
    }
    const bool fits = n % 4 >= 2;
    if (fits) core::fix_checksums(bytes);
    const bool differs = bytes != whole;
    MemoryFile damaged(std::move(bytes));
    WorldInfo info;
    const bool checked = check_world(damaged.source(), info).ok();
    // No checksum may miss it.
    EXPECT_FALSE(!fits && differs && checked) << n;
    // With the plan of the whole file, and with its own.
    refused += !try_file(damaged.source(), plan).ok();
    Plan own;
    own.needs = plan.needs;
    if (make_plan(damaged.source(), own).ok() && own.cpu_bytes <= memory().size()) {
      static_cast<void>(try_file(damaged.source(), own));
    }
  }
  EXPECT_GT(refused, 100);
  memory_is_usable();
}

// Fails from the n-th read on.
struct Failing {
  Source inside;
  int left = 0;
  Source source() {
    return {inside.bytes,
            [](void* user, std::uint64_t offset, std::byte* out, std::size_t count) {
              auto* const self = static_cast<Failing*>(user);
              return self->left-- > 0 && self->inside.read(self->inside.user, offset, out, count);
            },
            this};
  }
};

TEST_F(Worlds, EachReadMayFail) {
  const std::uint64_t before = file.reads();
  memory_is_usable();
  const int most = static_cast<int>(file.reads() - before);
  ASSERT_GT(most, 4);
  int failed = 0;
  for (int n = 0; n < most; n = n < 40 ? n + 1 : n + most / 40 + 1) {
    Failing failing{source, n};
    const Status status = try_file(failing.source(), plan);
    if (status.ok()) continue;  // the query's reads
    ++failed;
    EXPECT_EQ(status.code(), StatusCode::io) << n;
    EXPECT_STREQ(status.field(), "file") << n << " " << status.what();
  }
  EXPECT_GT(failed, 4);
  file.fails = true;
  WorldInfo info;
  Plan other;
  EXPECT_STREQ(make_plan(source, other).field(), "file");
  EXPECT_STREQ(read_world_info(source, info).field(), "file");
  EXPECT_STREQ(check_world(source, info).field(), "file");
  file.fails = false;
  // Without a function nothing can be read.
  EXPECT_STREQ(make_plan({source.bytes, nullptr, nullptr}, other).field(), "file");
  memory_is_usable();
}

TEST_F(Worlds, InfoIsThatOfTheHead) {
  WorldInfo head;
  const std::uint64_t before = file.reads();
  ASSERT_TRUE(read_world_info(source, head).ok());
  const std::uint64_t of_head = file.reads() - before;
  EXPECT_LT(of_head, 10u);
  WorldInfo checked;
  ASSERT_TRUE(check_world(source, checked).ok());
  EXPECT_GT(file.reads() - before - of_head, of_head);
  test::HostWorld host;
  const WorldInfo& info = host.world->info();
  for (const WorldInfo* other : {&head, &checked}) {
    EXPECT_EQ(info.voxel_size_m, other->voxel_size_m);
    EXPECT_EQ(info.origin_m.x, other->origin_m.x);
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(info.extent[axis], other->extent[axis]);
    EXPECT_EQ(info.octree_depth, other->octree_depth);
    EXPECT_EQ(info.level, other->level);
    EXPECT_EQ(info.octets, other->octets);
    EXPECT_EQ(info.volumes, other->volumes);
    EXPECT_EQ(info.patches, other->patches);
    EXPECT_EQ(info.height_blocks, other->height_blocks);
    EXPECT_EQ(info.materials, other->materials);
    EXPECT_EQ(info.lights, other->lights);
    EXPECT_STREQ(info.name, other->name);
  }
  EXPECT_EQ(info.extent[0], 40);
  EXPECT_EQ(info.extent[1], 24);
  EXPECT_EQ(info.extent[2], 36);
  EXPECT_EQ(info.level, 4);
  EXPECT_GT(info.patches, 1000u);
  EXPECT_LT(info.low_m.y, info.high_m.y);
  EXPECT_EQ(host.world->plan().cpu_bytes, host.plan.cpu_bytes);
}

TEST(Version, LibraryAndHeadersAgree) {
  EXPECT_EQ(api_version(), kApiVersion);
}

}  // namespace
}  // namespace karst
