#include "export/exporter.h"

#include "export/formats.h"

namespace gyrobench::exporting {

Exported Export(const calibration::Calibration& calibration, Format format, const Origin& origin) {
  switch (format) {
    case Format::kC:
      return WriteCHeader(calibration, origin);
    case Format::kPx4:
      return WritePx4(calibration, origin);
    case Format::kArduPilot:
      return WriteArduPilot(calibration, origin);
    case Format::kKalibr:
      return WriteKalibr(calibration, origin);
    case Format::kJson:
      break;
  }
  return WriteJson(calibration, origin);
}

}  // namespace gyrobench::exporting
