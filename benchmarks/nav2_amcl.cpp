// nav2_amcl's own filter behind five C functions, so that what is timed is its core and no binding.
//
// Built on demand against the sources of the package `amcl` (LGPL and GPL), for measuring only; see
// nav2_amcl.py. An update is what nav2 does for a scan: motion, sensor, resampling with its clusters.

#include <cstdlib>
#include <cstring>
#include <memory>

#include "nav2_amcl/map/map.hpp"
#include "nav2_amcl/motion_model/differential_motion_model.hpp"
#include "nav2_amcl/pf/pf.hpp"
#include "nav2_amcl/sensors/laser/laser.hpp"

using namespace nav2_amcl;

namespace {

struct Filter {
  map_t* map;
  pf_t* pf;
  std::unique_ptr<Laser> laser;
  DifferentialMotionModel motion;

  ~Filter() {
    laser.reset();
    pf_free(pf);
    map_free(map);
  }
};

pf_vector_t vector_of(const double* values) {
  pf_vector_t result;
  for (int i = 0; i < 3; i++) result.v[i] = values[i];
  return result;
}

// With both recovery alphas at zero it is never asked.
pf_vector_t no_random_pose(void*) { return pf_vector_zero(); }

}  // namespace

extern "C" {

// A map of cells that are 0 (free) or 100 (occupied), row 0 at the bottom, its corner at `origin`.
Filter* create(int particles, const signed char* cells, int width, int height, double scale,
               const double* origin, const double* alphas, const double* laser, int beams,
               int use_beam_model) {
  auto* filter = new Filter();
  map_t* map = filter->map = map_alloc();
  map->size_x = width;
  map->size_y = height;
  map->scale = scale;
  map->origin_x = origin[0] + (width / 2) * scale;
  map->origin_y = origin[1] + (height / 2) * scale;
  map->cells = static_cast<map_cell_t*>(std::calloc(width * height, sizeof(map_cell_t)));
  for (int i = 0; i < width * height; i++) map->cells[i].occ_state = cells[i] == 100 ? 1 : -1;
  filter->pf = pf_alloc(particles, particles, 0.0, 0.0, no_random_pose);
  filter->motion.initialize(alphas[0], alphas[1], alphas[2], alphas[3], 0.0);
  const double z_hit = laser[0], z_short = laser[1], z_max = laser[2], z_rand = laser[3];
  const double sigma = laser[4], lambda = laser[5], farthest = laser[6];
  if (use_beam_model) {
    filter->laser = std::make_unique<BeamModel>(z_hit, z_short, z_max, z_rand, sigma, lambda, 0.0,
                                                beams, map);
  } else {
    filter->laser =
        std::make_unique<LikelihoodFieldModel>(z_hit, z_rand, sigma, farthest, beams, map);
  }
  pf_vector_t at_robot = pf_vector_zero();
  filter->laser->SetLaserPose(at_robot);
  return filter;
}

void destroy(Filter* filter) { delete filter; }

void start(Filter* filter, const double* pose, const double* deviations) {
  pf_matrix_t covariance;
  std::memset(&covariance, 0, sizeof covariance);
  for (int i = 0; i < 3; i++) covariance.m[i][i] = deviations[i] * deviations[i];
  pf_init(filter->pf, vector_of(pose), covariance);
}

// `ranges` holds range and bearing of each ray.
void update(Filter* filter, const double* odometry, const double* delta, double* ranges, int count,
            double range_max) {
  filter->motion.odometryUpdate(filter->pf, vector_of(odometry), vector_of(delta));
  LaserData data;
  data.laser = filter->laser.get();
  data.range_count = count;
  data.range_max = range_max;
  data.ranges = reinterpret_cast<double(*)[2]>(ranges);
  filter->laser->sensorUpdate(filter->pf, &data);
  data.ranges = nullptr;  // not its own
  pf_update_resample(filter->pf, filter->map);
}

void estimate(Filter* filter, double* mean) {
  const pf_sample_set_t* set = filter->pf->sets + filter->pf->current_set;
  for (int i = 0; i < 3; i++) mean[i] = set->mean.v[i];
}
}
