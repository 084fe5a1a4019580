// SPDX-License-Identifier: MIT
// OGRE 1.12's Terrain with its own material (TerrainMaterialGeneratorA) of five layers over the shared scene:
// blend maps, diffuse and specular, normals; like peer_ogre.cpp else.
//
// peer_ogre_layers [gl3plus|gles2] [maxPixelError=8] [parallax=1] [metres a repeat=100] [piece=30] [dump]
// piece: of each 30 frames of the flight only so many are drawn. dump: errors, textures of the material, and
// pictures of the first frame and of a place near the ground, ogre_SYSTEM_{far,near}.png. With PEER_SHADER
// set, also the fragment program that OGRE made.
#include <GL/gl.h>
#include <Ogre.h>
#include <OgreRTShaderSystem.h>
#include <OgreSGTechniqueResolverListener.h>
#include <OgreTerrain.h>
#include <OgreTerrainLayerBlendMap.h>
#include <OgreTerrainMaterialGeneratorA.h>
#include <png.h>

#include "tests/bench/peers/layers.h"
using namespace peer;

namespace {

struct Options {
  std::string system = "gl3plus";
  float pixel_error = 8;
  bool parallax = true;
  float repeat_m = 100;
  int piece = 30;
  bool dump = false;
};

void write_picture(const std::string& path) {
  std::vector<uint8_t> rgba(size_t(kW) * kH * 4);
  glReadPixels(0, 0, kW, kH, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  for (size_t n = 3; n < rgba.size(); n += 4) rgba[n] = 255;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = kW;
  image.height = kH;
  image.format = PNG_FORMAT_RGBA;
  // The last row is the top one.
  png_image_write_to_file(&image, path.c_str(), 0, rgba.data(), -kW * 4, nullptr);
}

void add_media() {
  auto& groups = Ogre::ResourceGroupManager::getSingleton();
  const std::string media = OGRE_MEDIA_DIR;
  for (const char* folder : {"/ShadowVolume", "/RTShaderLib/materials", "/RTShaderLib/GLSL", "/Terrain"}) {
    groups.addResourceLocation(media + folder, "FileSystem", Ogre::RGN_INTERNAL);
  }
  groups.addResourceLocation(data_path(""), "FileSystem");
}

// A light without specular would leave the specular maps without an effect.
void add_light(Ogre::SceneManager* scene, const Ogre::Vector3& direction) {
  scene->setAmbientLight(Ogre::ColourValue(kAmbient, kAmbient, kAmbient));
  Ogre::Light* light = scene->createLight();
  light->setType(Ogre::Light::LT_DIRECTIONAL);
  light->setSpecularColour(Ogre::ColourValue(0.5f, 0.5f, 0.5f));
  auto* node = scene->getRootSceneNode()->createChildSceneNode();
  node->attachObject(light);
  node->setDirection(direction, Ogre::Node::TS_WORLD);
}

// As OGRE has it by default, but for what stands for shadows (light map) or for a distance that the scene
// does not have (composite map), and parallax where it is switched off.
void set_material(const Options& options, const Ogre::Vector3& light, Ogre::SceneManager* scene) {
  auto* globals = OGRE_NEW Ogre::TerrainGlobalOptions;
  globals->setMaxPixelError(options.pixel_error);
  globals->setCompositeMapDistance(1e9f);
  globals->setLightMapDirection(light);
  globals->setCompositeMapAmbient(scene->getAmbientLight());
  globals->setCastsDynamicShadows(false);
  auto* profile = static_cast<Ogre::TerrainMaterialGeneratorA::SM2Profile*>(
      globals->getDefaultMaterialGenerator()->getActiveProfile());
  profile->setLayerNormalMappingEnabled(true);
  profile->setLayerSpecularMappingEnabled(true);
  profile->setLayerParallaxMappingEnabled(options.parallax);
  profile->setGlobalColourMapEnabled(false);
  profile->setLightmapEnabled(false);
  profile->setCompositeMapEnabled(false);
  profile->setReceiveDynamicShadowsEnabled(false);
}

void fill_blend_maps(Ogre::Terrain& terrain, const Heightmap& map) {
  const int side = terrain.getLayerBlendMapSize();
  for (int n = 1; n < kLayers; ++n) {
    Ogre::TerrainLayerBlendMap* blend = terrain.getLayerBlendMap(Ogre::uint8(n));
    float* out = blend->getBlendPointer();
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {  // rows run from -z to +z, as the map's
        const int i = std::min(int((x + 0.5) / side * kN), kN - 1),
                  j = std::min(int((y + 0.5) / side * kN), kN - 1);
        *out++ = float(cover(kLayer[n], normal_y(map, i, j), map.h(i, j)));
      }
    }
    blend->dirty();
    blend->update();
  }
}

bool load(Ogre::Terrain& terrain, const Options& options, const Heightmap& map) {
  std::vector<float> heights(size_t(kN) * kN);  // ALIGN_X_Z: rows run towards -z
  for (int j = 0; j < kN; ++j) {
    for (int i = 0; i < kN; ++i) heights[size_t(j) * kN + i] = float(map.h(i, kN - 1 - j));
  }
  Ogre::Terrain::ImportData import;
  import.terrainAlign = Ogre::Terrain::ALIGN_X_Z;
  import.terrainSize = kN;
  import.worldSize = kWorld;
  import.minBatchSize = 33;
  import.maxBatchSize = 65;
  import.inputFloat = heights.data();
  for (const Layer& layer : kLayer) {
    Ogre::Terrain::LayerInstance& instance = import.layerList.emplace_back();
    instance.worldSize = options.repeat_m;
    instance.textureNames = {std::string(layer.name) + "_diffuse_specular.png",
                             std::string(layer.name) + "_normal_height.png"};
  }
  if (!terrain.prepare(import)) return false;
  terrain.load(0, true);
  fill_blend_maps(terrain, map);
  return true;
}

// What OGRE made of it, so that nobody has to believe that it draws five layers.
void print_material(const Ogre::Terrain& terrain) {
  const Ogre::Pass* pass = terrain.getMaterial()->getTechnique(0)->getPass(0);
  for (unsigned short n = 0; n < pass->getNumTextureUnitStates(); ++n) {
    std::printf("TEXTURE %u %s\n", n, pass->getTextureUnitState(n)->getTextureName().c_str());
  }
  std::printf("LAYERS %d\n", terrain.getLayerCount());
  if (std::getenv("PEER_SHADER") != nullptr) std::puts(pass->getFragmentProgram()->getSource().c_str());
}

Options parse(int argc, char** argv) {
  Options options;
  if (argc > 1) options.system = argv[1];
  if (argc > 2) options.pixel_error = float(atof(argv[2]));
  if (argc > 3) options.parallax = atoi(argv[3]) != 0;
  if (argc > 4) options.repeat_m = float(atof(argv[4]));
  if (argc > 5) options.piece = atoi(argv[5]);
  options.dump = argc > 6;
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = parse(argc, argv);
  Bench bench;
  Ogre::LogManager log;
  log.createLog("ogre_layers.log", true, false, false);
  Ogre::Root root("", "", "");
  const bool gles = options.system == "gles2";
  root.loadPlugin(std::string(OGRE_PLUGIN_DIR) + (gles ? "/RenderSystem_GLES2" : "/RenderSystem_GL3Plus"));
  root.loadPlugin(std::string(OGRE_PLUGIN_DIR) + "/Codec_STBI");
  root.setRenderSystem(root.getAvailableRenderers().at(0));
  root.initialise(false);
  Ogre::NameValuePairList window_options{{"vsync", "false"}, {"FSAA", "0"}, {"hidden", "false"}};
  Ogre::RenderWindow* window = root.createRenderWindow("peer", kW, kH, false, &window_options);
  add_media();
  Ogre::RTShader::ShaderGenerator::initialize();
  auto* generator = Ogre::RTShader::ShaderGenerator::getSingletonPtr();
  OgreBites::SGTechniqueResolverListener resolver(generator);
  Ogre::MaterialManager::getSingleton().addListener(&resolver);
  Ogre::ResourceGroupManager::getSingleton().initialiseAllResourceGroups();
  Ogre::MaterialManager::getSingleton().setDefaultTextureFiltering(Ogre::TFO_BILINEAR);

  Ogre::SceneManager* scene = root.createSceneManager();
  generator->addSceneManager(scene);
  Ogre::Vector3 light(kLightDir[0], kLightDir[1], kLightDir[2]);
  light.normalise();
  add_light(scene, light);
  Ogre::Camera* camera = scene->createCamera("c");
  camera->setFOVy(Ogre::Degree(kFovY));
  camera->setAspectRatio(float(kW) / kH);
  camera->setNearClipDistance(kNear);
  camera->setFarClipDistance(kFar);
  auto* eye = scene->getRootSceneNode()->createChildSceneNode();
  eye->attachObject(camera);
  eye->setFixedYawAxis(true);
  auto* view = window->addViewport(camera);
  view->setBackgroundColour(Ogre::ColourValue(0.5f, 0.7f, 0.9f));
  view->setOverlaysEnabled(false);
  set_material(options, light, scene);
  const Heightmap map = load_heightmap();
  Ogre::Terrain terrain(scene);
  if (!load(terrain, options, map)) return 1;

  const auto draw = [&](V3 e, V3 t) {
    eye->setPosition(e.x, e.y, e.z);
    eye->lookAt(Ogre::Vector3(t.x, t.y, t.z), Ogre::Node::TS_WORLD);
    root._fireFrameStarted();
    window->update(false);  // no buffer swap
    root._fireFrameEnded();
    glFinish();
  };
  for (const bool measured : {false, true}) {
    for (int i = 0; i < kFrames; ++i) {
      if (i % 30 >= options.piece) continue;
      bench.begin();
      draw(eye_at(i), target_at(i));
      bench.end(measured);
      if (bench.load == 0) bench.load = now_ms() - bench.t0;
      if (!measured) continue;
      const auto statistics = window->getStatistics();
      bench.tris.push_back(double(statistics.triangleCount));
      bench.batches.push_back(double(statistics.batchCount));
    }
  }
  const std::string name =
      "ogre-layers/" + options.system + "/err" + std::to_string(int(options.pixel_error));
  bench.report(name.c_str());
  std::printf("MEDIANS frame %.2f cpu %.2f\n", Bench::pct(bench.wall, .5), Bench::pct(bench.proc, .5));
  if (options.dump) {
    ErrorStats errors;
    std::vector<float> depth(size_t(kW) * kH);
    for (int i = 0; i < kFrames; i += 40) {
      draw(eye_at(i), target_at(i));
      if (i == 0) write_picture("ogre_" + options.system + "_far.png");
      if (gles) continue;  // ES gives no depth back
      glReadPixels(0, 0, kW, kH, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());
      accumulate_error(map, i, depth.data(), errors);
    }
    report_error(name.c_str(), errors);
    print_material(terrain);
    const double ground = map.at(700, 400) + 12;
    draw({700, ground, 400}, {500, ground - 60, 300});
    write_picture("ogre_" + options.system + "_near.png");
  }
  fflush(stdout);
  _exit(0);
}
